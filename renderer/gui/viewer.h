// Requests of the user to the viewer, written by keys, mouse and panels, and executed by the frame loop.
// Plain structs, main thread only; independent of window and panels.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "renderer/passes/debug/inspection.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::gui {

// Playout of a stream, overriding the command line.
struct StreamPlayout {
  bool interpolate = false;
  std::optional<int64_t> delay_ns;  // empty: adapts to the jitter
  bool operator==(const StreamPlayout&) const = default;
};

// One-shot commands, cleared after execution.
struct Commands {
  bool frame_all = false, frame_selection = false;
  std::optional<size_t> camera;  // index of the scene's camera
  bool free_camera = false;      // switches to the free camera at the current pose
  bool screenshot = false;
  bool toggle_video = false;
  bool close = false;
  std::optional<std::filesystem::path> open;  // scene, description or recording to show next
};

// Node and material numbers refer to the displayed scene. Another scene inherits the settings of nodes with
// the same paths.
struct Viewer {
  uint32_t selected = scene::kNone;  // node
  uint32_t followed = scene::kNone;  // node that the free camera follows
  uint32_t isolated = scene::kNone;  // only this node and its descendants are drawn
  std::set<uint32_t> hidden;         // including descendants
  // Overrides of the file's and streams' values; erasing an entry restores them.
  std::map<uint32_t, scene::Light> lights;  // by node
  // By number: factors only; textures and alpha modes are unchanged.
  std::map<uint32_t, scene::Material> materials;

  passes::DrawSettings draw;  // requested settings; unsupported ones are reported and reset
  passes::DebugView debug_view = passes::DebugView::none;
  std::map<uint64_t, StreamPlayout> streams;  // by epoch
  float camera_speed = 1;                     // factor on the speed derived from the scene's size

  bool gui = true, help = false;
  Commands commands;
};

}  // namespace fire3dv::gui
