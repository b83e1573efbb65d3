// State that the user changes: of the displayed document and of the window's view, and one-shot commands.
// Plain structs, main thread only; independent of window, panels and Vulkan.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "renderer/scene/model/scene.h"
#include "renderer/settings/debug_view.h"
#include "renderer/settings/draw_settings.h"
#include "renderer/state/edits/user_edits.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

// Playout of a stream, overriding the command line.
struct StreamPlayout {
  bool interpolate = false;
  std::optional<int64_t> delay_ns;  // empty: adapts to the jitter
  bool operator==(const StreamPlayout&) const = default;
};

// Handles over the selected node.
enum class GizmoTool : uint8_t { none, move, rotate, scale };

// Objects that the user adds to the scene.
enum class ObjectKind : uint8_t { point_light, spot_light, directional_light, camera };

// What the user does with an input that the stream of this epoch declares.
struct InputCommand {
  uint64_t epoch = 0;
  wire::InputEvent event;
};

// One-shot commands, cleared after execution.
struct Commands {
  bool frame_all = false, frame_selection = false;
  std::optional<size_t> camera;  // index of the scene's camera
  bool free_camera = false;      // switches to the free camera at the current pose
  bool focus_on_point = false;   // the lens, on ViewState::picked_point
  bool screenshot = false;
  bool toggle_video = false;
  std::optional<std::string> export_csv;  // table to write into a file
  bool undo = false, redo = false, save_overlay = false, export_glb = false;
  std::optional<std::filesystem::path> save_as;  // overlay file of this save and the next ones
  std::optional<ObjectKind> add;
  bool duplicate = false;                      // the selected node
  std::optional<std::string> add_asset;        // URI of a glTF file, one of EditFacts::assets
  bool list_assets = false;                    // looks for them again
  std::optional<std::string> remove_addition;  // name of one of EditFacts::refused
  std::optional<bool> recover;                 // EditFacts::recovered: true applies, false discards them
  // Of the timeline of a replay or of animations, if there is one.
  bool toggle_playback = false;
  int step_frames = 0;  // forwards (> 0) or backwards
  double skip_s = 0;    // forwards or backwards
  std::vector<InputCommand> inputs;
  bool close = false;
  std::optional<std::filesystem::path> open;  // scene, description or recording to show next
};

// Point of a surface. It moves with its node.
struct SurfacePoint {
  uint32_t node = scene::kNone;  // kNone: at rest, position_node is in the world
  glm::vec3 position_node{0};
  bool operator==(const SurfacePoint&) const = default;
};
glm::vec3 position_world(const SurfacePoint& point, const state::PoseState& poses);

// The stream that drives this node itself; null: none. A node below a driven one can be moved.
const std::string* direct_driver_of(const state::PoseState& poses, uint32_t node);

// Size of the window's screenshots; see screenshot_px().
struct ScreenshotSize {
  enum class Kind : uint8_t {
    window,
    twice,
    four_times,
    fixed
  };  // the first three: of the image in the window
  Kind kind = Kind::window;
  std::string fixed_px = "3840x2160";  // WxH
  bool operator==(const ScreenshotSize&) const = default;
};

// State of the displayed document that the user changes, with and without a window. Another scene inherits
// the edits of nodes with the same paths.
struct DocumentState {
  state::UserEdits edits;
  settings::DrawSettings draw;   // requested settings; unsupported ones are reported and reset
  settings::PathSettings paths;  // of draw.path, while it is set
  settings::DebugView debug_view = settings::DebugView::none;
};

// State of the window's view and requests of the user, written by keys, mouse and panels, and executed by the
// frame loop. Node numbers refer to the displayed scene.
struct ViewState : DocumentState {
  uint32_t selected = scene::kNone;                // node
  uint32_t followed = scene::kNone;                // node that the free camera follows
  std::optional<SurfacePoint> picked_point;        // of the last click on a surface
  bool shows_grid = false, shows_frusta = false;   // ground grid with axes; frusta of the scene's cameras
  bool can_drag_bodies = false;                    // Ctrl-drag does not turn the camera
  std::optional<std::array<glm::vec3, 2>> spring;  // of a dragged body, in the world: its point, the target
  bool measures = false;                           // clicks choose points instead of nodes
  std::vector<SurfacePoint> measured;              // at most two
  std::map<uint64_t, StreamPlayout> streams;       // by epoch
  ScreenshotSize screenshot_size;
  float camera_speed = 1;  // factor on the speed derived from the scene's size

  GizmoTool tool = GizmoTool::none;
  bool tool_is_local = false;     // handles have the axes of the node, not of the world
  bool scale_is_uniform = false;  // typed factors change together
  std::string save_path;          // text of the field beside "Save as"
  bool gui = true, help = false;
  Commands commands;
};

// Addition of the user that is not displayed.
struct RefusedAddition {
  std::string name, reason;
};

// Undo history and files of the user's edits.
struct EditFacts {
  std::string undo, redo;  // what the next step changes; empty: there is none
  bool is_saved = true;
  std::string file;                      // overlay file; empty: there is nowhere to save
  std::vector<std::string> assets = {};  // glTF files of its folder and of --assets, as URIs
  std::string notice = {};               // shown over the image; empty: none
  std::vector<RefusedAddition> refused = {};
  std::string recovered = {};  // question about unsaved edits of an earlier run; empty: none
};

}  // namespace fire3dv::app
