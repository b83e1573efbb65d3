// Window side of the frame loop: user input, presentation, screenshots and secondary windows. The frame loop
// renders with the camera that this class controls.
// More than 60 members: whatever a window's events act on meets here, in the order of one frame.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/camera/camera_rig.h"
#include "renderer/camera/default_look.h"
#include "renderer/editing/edit_session.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gui/panel_data.h"
#include "renderer/gui/screenshot_size.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/streams/image_request_queue.h"
#include "renderer/streams/playout_options.h"
#include "renderer/streams/stream_receiver.h"
#include "renderer/window/body_drag.h"
#include "renderer/window/overlay_markers.h"
#include "renderer/window/recent_files.h"
#include "renderer/window/screenshots/screenshot_recorder.h"
#include "renderer/window/unsaved_edits.h"
#include "renderer/window/view_control.h"
#include "renderer/window/window.h"
#include "renderer/window/window_panels.h"

namespace fire3dv::app {

// Secondary window: another camera view of the displayed scene.
class CameraWindow {
 public:
  // Borrows device and window. The window is attached to the device.
  CameraWindow(gpu::Device& device, sinks::Window& window, CameraRig camera)
      : window_(window), camera_(std::move(camera)), frames_(device) {}

  // Handles the window's input, including global commands. Returns false if the window is to be closed.
  bool steer(ViewState& view_state, const state::PoseState& poses, float seconds);
  // Renders and presents; skips the frame if the window cannot be shown.
  Result<void> draw(passes::SceneRenderer& renderer, const state::PoseState& poses,
                    const ViewState& view_state, uint64_t scene_number, StaleOverlay stale_overlay,
                    bool in_motion);

  const sinks::Window& window() const { return window_; }
  CameraRig& camera() { return camera_; }

 private:
  sinks::Window& window_;
  CameraRig camera_;
  ViewInput input_;
  gpu::FrameRing frames_;
  std::optional<glm::vec2> clicked_px_;
};

struct OpenWindow {
  std::unique_ptr<sinks::Window> window;
  std::string camera;  // as in the options; empty: not set
};
using Windows = std::vector<OpenWindow>;

struct WindowViewOptions {
  bool has_panels = true;                // over the first window's image
  std::optional<bool> has_light_panels;  // theme; nullopt: as in the last window
  std::string right_camera;              // second view in the first window; empty: none
  ViewDefaults view;
  VkExtent2D size{};                  // of a window that is minimised from the start
  std::filesystem::path screenshots;  // folder of screenshots and videos
  ScreenshotSize screenshot_size;
  std::string file;  // scene or recording, for the list of recent files
  StaleOverlay stale_overlay = StaleOverlay::interpolated;
  // Other consumers of the renderer, which the window's settings must not disturb.
  bool writes_images = false;  // --out
  bool has_outputs = false;    // --outputs
  bool has_secondary_devices = false, has_live_view = false, is_lockstep = false;
};

class WindowView {
 public:
  // Borrows everything. `camera` belongs to the first window; the others use their own. windows:
  // at least one; closed windows are removed.
  struct Borrowed {
    gpu::Device& device;
    std::optional<passes::SceneRenderer>& renderer;  // never empty
    state::PoseState& poses;
    StreamReceiver& receiver;
    ImageRequestQueue& requests;
    LiveScene& scene;
    CameraRig& camera;
    Windows& windows;
    ViewState& view_state;
    EditSession& editor;
    WindowViewOptions options;
    std::vector<uint32_t> animations;  // those that play
    std::optional<state::RobotPose>& robot;
    bool insist = true;  // an unknown camera of the options is an error; otherwise another camera is used
  };
  // Fails for an unknown camera.
  static Result<std::unique_ptr<WindowView>> create(const Borrowed& borrowed);
  WindowView(const WindowView&) = delete;
  WindowView& operator=(const WindowView&) = delete;

  // Applies user input to cameras and scene. facts: for panels. timeline: null without replay.
  void steer(const gui::Facts& facts, replay::TimelineControl* timeline);
  // Takes the events of all windows. True if there is news for the user: input since the last call, a picked
  // node, or a video that is recorded.
  bool take_activity();
  bool should_close() const { return closing_; }
  std::optional<std::filesystem::path> take_opened() { return std::exchange(opened_, std::nullopt); }
  // Asks before the next document, which is loaded, replaces this one. False: edits since the request would
  // be lost, as the user is told; it is held until they are saved or undone, or the user opens a file again.
  bool may_show_next();
  bool holds_next() const;  // may_show_next() would still refuse
  // The edits of an interaction that goes on are a step, too.
  void record_unfinished_edits();
  // Messages to the user since the last call. Call often, also while no image is drawn: it protects unsaved
  // edits, too.
  std::vector<std::string> take_log_messages();

  bool records_video() const { return captures_.records_video(); }
  // True if a screenshot or video shows the next image.
  bool captures_image() const { return captures_.captures_image(); }

  // Of each image in the first window: the rectangle that its panels leave.
  VkExtent2D image_extent() const { return image_extent_; }
  bool acquire() { return first().acquire(); }  // false: the window cannot be shown now

  // Markers that the window adds to its next image; none while images are written to files (--out).
  std::span<const state::ShownMarker> update_overlay();
  // Inspection settings of the window's next image.
  passes::Inspection take_inspection();
  // Call after the image's passes: records the copy to the display and the remaining content of the window.
  // in_motion: see passes::FrameRequest.
  Result<void> record(gpu::Recorder& recorder, gpu::StagingRing& staging, ScreenshotRecorder::Tag shown,
                      bool in_motion);
  std::array<gpu::SemaphoreSignal, 1> waits() const { return first().waits(); }
  std::array<gpu::SemaphoreSignal, 1> signals() const { return first().signals(); }
  void present(uint64_t timeline_value);
  Result<void> draw_others(bool in_motion);  // secondary windows, one submission each
  void deliver();                            // screenshots to files, and picking results
  void finish() { captures_.finish(); }

 private:
  explicit WindowView(const Borrowed& borrowed);
  sinks::Window& first() const { return *borrowed_.windows.front().window; }
  uint32_t columns() const { return right_camera_ ? 2 : 1; }
  void steer_first(float seconds, const gui::Facts& facts, replay::TimelineControl* timeline);
  void measure();
  void request_screenshot();
  void record_large_screenshot(gpu::Recorder& recorder, gpu::StagingRing& staging,
                               const ScreenshotRecorder::Tag& shown, glm::uvec2 size);
  void place_image();
  state::EditTargets edit_targets() const;
  void close_or_open(const sinks::WindowInput& input, bool view_has_mouse);
  void drag_body(const CameraMoves& moves);
  void apply_requests();
  std::optional<std::string> why_no_paths();
  void apply_draw_settings();
  bool is_interacting() const { return panels_ && panels_->is_interacting(); }
  passes::SceneRenderer& renderer() { return *borrowed_.renderer; }

  const Borrowed borrowed_;
  UnsavedEdits unsaved_;
  ViewInput input_;
  std::optional<CameraRig> right_camera_;  // second view of the first window
  std::vector<std::unique_ptr<CameraWindow>> others_;
  ScreenshotRecorder captures_;
  OverlayMarkers overlay_;
  BodyDrag body_drag_;
  RecentFiles recent_files_;
  float display_scale_ = 1;
  std::optional<WindowPanels> panels_;
  VkExtent2D window_extent_{};  // of each column
  VkExtent2D image_extent_{};
  glm::uvec2 image_at_px_{0};  // upper left corner of the image in the window
  std::optional<glm::vec2> clicked_px_, clicked_right_px_, grabbed_px_;
  settings::DrawSettings drawn_;  // last valid settings
  bool closing_ = false;
  std::optional<glm::uvec2> large_screenshot_px_;  // to draw next: not of the size in the window
  std::vector<std::string> notes_;
  std::optional<std::filesystem::path> opened_;
  std::chrono::steady_clock::time_point steered_ = std::chrono::steady_clock::now();
  bool has_picked_ = false;  // since the last take_activity()
};

}  // namespace fire3dv::app
