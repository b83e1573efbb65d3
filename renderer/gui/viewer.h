// What the user wants of the viewer, beside what streams send: keys, the mouse and panels write it, and the
// frame loop does it. Plain data, of the main thread; whoever reads it needs neither a window nor a panel.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "renderer/passes/debug_view.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/scene.h"

namespace fire3dv::gui {

// How a stream is shown in time, instead of what the command line says.
struct StreamWish {
  bool interpolate = false;
  std::optional<int64_t> delay_ns;  // nothing: it follows the jitter
  bool operator==(const StreamWish&) const = default;
};

// Is done once, and is then gone.
struct Commands {
  bool frame_all = false, frame_selection = false;
  std::optional<size_t> camera;  // of the scene, in its order
  bool free_camera = false;      // go on from where the camera is
  bool screenshot = false;
  bool toggle_video = false;
  bool close = false;
  std::optional<std::filesystem::path> open;  // scene, description or recording, to show instead
};

// Numbers of nodes and materials are those of the scene that is shown. When another one takes its place,
// nodes stay what they are as far as their paths are found in it.
struct Viewer {
  uint32_t selected = scene::kNone;  // node
  uint32_t followed = scene::kNone;  // the free camera moves with this node
  uint32_t isolated = scene::kNone;  // only this node and what is below it is drawn
  std::set<uint32_t> hidden;         // with what is below them
  // Instead of those of the file and of streams; taken out, these show again.
  std::map<uint32_t, scene::Light> lights;        // by node
  std::map<uint32_t, scene::Material> materials;  // by number: factors count, textures and modes stay

  passes::DrawSettings draw;  // as it should be; what cannot be had is said and set back
  passes::DebugView debug_view = passes::DebugView::none;
  std::map<uint64_t, StreamWish> streams;  // by epoch
  float camera_speed = 1;                  // factor on what follows from the scene's size

  bool gui = true, help = false;
  Commands commands;
};

}  // namespace fire3dv::gui
