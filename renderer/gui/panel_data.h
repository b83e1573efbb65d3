// Data between panels and the frame loop: requests of the user, and numbers to display. Plain structs, main
// thread only; independent of window and panels.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/peer_budget.h"
#include "renderer/gui/screenshot_size.h"
#include "renderer/scene/model/scene.h"
#include "renderer/settings/debug_view.h"
#include "renderer/settings/draw_settings.h"
#include "renderer/state/edits/user_edits.h"
#include "renderer/state/pose_state.h"
#include "renderer/state/stream_timing.h"

namespace fire3dv::gui {

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
  // Of the timeline of a replay or of animations, if there is one.
  bool toggle_playback = false;
  int step_frames = 0;  // forwards (> 0) or backwards
  double skip_s = 0;    // forwards or backwards
  bool close = false;
  std::optional<std::filesystem::path> open;  // scene, description or recording to show next
};

// Point of a surface. It moves with its node.
struct SurfacePoint {
  uint32_t node = scene::kNone;  // kNone: at rest, position_node is in the world
  glm::vec3 position_node{0};
  bool operator==(const SurfacePoint&) const = default;
};
inline glm::vec3 position_world(const SurfacePoint& point, const state::PoseState& poses) {
  if (point.node >= poses.node_drives().size()) return point.position_node;
  return poses.world_from_node(point.node) * glm::vec4(point.position_node, 1);
}

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
  uint32_t selected = scene::kNone;               // node
  uint32_t followed = scene::kNone;               // node that the free camera follows
  std::optional<SurfacePoint> picked_point;       // of the last click on a surface
  bool shows_grid = false, shows_frusta = false;  // ground grid with axes; frusta of the scene's cameras
  bool measures = false;                          // clicks choose points instead of nodes
  std::vector<SurfacePoint> measured;             // at most two
  std::map<uint64_t, StreamPlayout> streams;      // by epoch
  ScreenshotSize screenshot_size;
  float camera_speed = 1;  // factor on the speed derived from the scene's size

  GizmoTool tool = GizmoTool::none;
  bool tool_is_local = false;  // handles have the axes of the node, not of the world
  std::string save_path;       // text of the field beside "Save as"
  bool gui = true, help = false;
  Commands commands;
};

// --- numbers to display, gathered once per frame ---

struct PassFact {
  std::string name;
  double ms = 0;
  bool is_async = false;  // on the async compute queue
};

struct FrameFacts {
  uint64_t images = 0;     // drawn so far; if unchanged, all values here are unchanged
  double interval_ms = 0;  // since the previous image
  double cpu_ms = 0;       // recording and submission
  double gpu_ms = 0;       // newest finished frame
  std::optional<double> pose_age_ms;
  std::vector<PassFact> passes;  // of that frame, in execution order
  glm::uvec2 extent_px{0};
  // Counts of the displayed scene, with instancing.
  uint64_t triangles = 0;
  uint64_t clusters = 0;
  std::optional<uint64_t> clusters_drawn;  // after culling; empty if the raster path does not count them
  uint64_t late_clusters = 0;              // the part drawn by the second (disocclusion) pass
  uint64_t shadow_rays = 0;
  uint64_t gpu_bytes = 0;  // allocated by this program
  uint64_t resident_bytes = 0;
  std::string device, raster, shadows;  // display texts
  uint32_t samples = 0;
  std::optional<settings::PathProgress> paths;  // of a path-traced image; empty: raster
};

constexpr size_t kMaxMarkerNamespaces = 32;

// Use of one resource by a stream's peer.
struct UseFact {
  Resource resource{};
  uint64_t used = 0, limit = 0, refused = 0;
};

struct MarkerFact {
  std::string name;  // of a namespace
  uint64_t markers = 0;
};

struct StreamFact {
  uint64_t epoch = 0;
  std::string name, listener, clock;
  state::Condition condition = state::Condition::live;
  bool interpolated = false;
  int64_t delay_ns = 0;          // playout delay, if interpolated
  double rate_hz = 0;            // whole frames per second
  std::optional<double> age_ms;  // age of the displayed frame since its publication
  uint64_t sequence = 0;
  int64_t sim_time_ns = 0;
  uint32_t poses = 0, unmatched = 0, conflicting = 0;
  uint64_t shown = 0;  // displayed frames
  // Frames and messages that were not displayed, by cause.
  uint64_t incomplete = 0, stale = 0, refused = 0, baseless = 0, overtaken = 0;
  uint64_t edits = 0, edits_refused = 0;
  std::vector<MarkerFact> marker_namespaces;  // at most kMaxMarkerNamespaces, by name
  uint64_t more_marker_namespaces = 0;        // beyond these
  std::vector<UseFact> uses;                  // above 1 % of the limit, or with refusals
  std::vector<float> gaps_ms;                 // intervals between the newest frames, oldest first
};

struct LinkFact {
  std::string uri;
  uint32_t peers = 0;
  uint64_t received_bytes = 0, poses_dropped = 0, frames_dropped = 0, rejected = 0;
};

struct LogLine {
  double time_s = 0;  // since program start
  std::string text;
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
};

struct Facts {
  FrameFacts frame;
  std::vector<StreamFact> streams;
  std::vector<LinkFact> links;
  std::vector<LogLine> log;      // newest lines, oldest first
  uint64_t log_lines = 0;        // total; lines before `log` are dropped
  std::optional<size_t> camera;  // index of the scene's camera; empty: free camera
  bool recording_video = false;
  // Reasons for features that this device or scene does not support; empty: supported.
  std::string why_no_debug_views;
};

}  // namespace fire3dv::gui
