// Frame loop of the renderer: polls streams and input, renders, and delivers images.
#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "base/progress.h"
#include "protocol/replay/replay_clock.h"
#include "renderer/app/animation_timeline.h"
#include "renderer/app/frame_stats.h"
#include "renderer/app/options/options.h"
#include "renderer/app/path_checkpoint.h"
#include "renderer/app/recording.h"
#include "renderer/app/renderer_metrics.h"
#include "renderer/app/viewer_document.h"
#include "renderer/browser/live_view.h"
#include "renderer/camera/camera_rig.h"
#include "renderer/capture/capture.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/images/image_service.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/loading/scene_reload.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"
#include "renderer/state/motion/animation.h"
#include "renderer/state/motion/animation_clock.h"
#include "renderer/state/motion/robot_pose.h"
#include "renderer/streams/stream_receiver.h"
#include "renderer/window/window_panels.h"
#include "renderer/window/window_view.h"

namespace fire3dv::app {

// Draw settings of the command line. environment: null for the studio environment.
passes::DrawSettings draw_settings(const Options& options,
                                   std::shared_ptr<const scene::EnvironmentImage> environment);
// Warning for ray effects that the device cannot trace; empty: none.
std::string lacking_ray_effects(const gpu::Device& device, const Options& options);

// Objects that a frame loop works with. All are borrowed.
struct FrameLoopContext {
  gpu::Device& device;
  passes::SceneRenderer& renderer;  // has its scene
  state::PoseState& poses;
  StreamReceiver& receiver;
  ImageRequestQueue& requests;
  LiveScene& scene;
  state::AnimationPlayer* animations = nullptr;      // null: none play
  std::optional<state::RobotPose>* robot = nullptr;  // of the file; null: nobody moves its joints
  CameraRig& camera;
  sinks::FrameSink& sink;
  WindowView* window = nullptr;  // null: no window
  FrameStats& stats;
  const Options& options;
};

class FrameLoop {
 public:
  explicit FrameLoop(const FrameLoopContext& context);

  // Borrowed; null: no metrics. Call before run().
  void report_to(RendererMetrics* metrics) { metrics_ = metrics; }
  // Borrowed; null: no replay or recording. Call before run().
  void follow(replay::TimelineControl* timeline) { timeline_ = timeline; }
  void record_with(Recording* recording) { recording_ = recording; }
  // Borrowed; null: no viewers in browsers. Call before run().
  void show_in_browsers(LiveView* live_view);
  // Borrowed secondary devices that also render image requests, with the current settings. Call before run().
  void spread_images_over(SecondaryDevices& further, const passes::DrawSettings& settings) {
    image_service_.spread_over(further, settings);
    std::vector<const gpu::Device*> devices;
    for (const auto& each : further.all()) devices.push_back(&each->device());
    scene_.set_secondary_devices(std::move(devices));
  }
  // Ends run() when the next scene is loaded.
  void go_on_with(DocumentLoader* next) { next_ = next; }
  // Interrupted path-traced images of a run without a window go on. Call before run().
  Result<void> keep_checkpoints();
  // Borrowed; null: the scene stays when its file changes. Call before run().
  void reload_with(SceneReload* reload) { reload_ = reload; }
  Result<void> run();
  bool switches_document() const { return goes_on_; }  // true if run() ended for the next scene
  uint64_t images() const { return images_; }

 private:
  ViewerNumbers viewer_numbers() const;
  bool done();
  Result<void> await_stream();  // clears awaits_stream_ at the first pose frame; fails after the timeout
  void log_notes();
  bool poll_streams();  // polls streams; true if there is a new pose frame
  void steer();         // applies user input
  void animate();
  void pose_by_hand();
  void set_rest(const state::RestPose& rest);
  void animate_for_viewers();
  Result<void> draw();
  passes::PathPass::Hooks path_hooks(const passes::View& view, Progress& progress);
  void report_stopped_paths() const;
  bool refines() const;  // the window's image lacks path-traced samples
  Result<void> finish_served(const ImageService::Drawn& served);
  Result<void> deliver();  // passes finished images to the sink
  Result<void> list_instances();
  void warn_of_empty_image(const passes::View& view, const std::vector<state::FrameTag>& shown);
  void note_cost(const std::vector<state::FrameTag>& shown, std::chrono::steady_clock::time_point begun);
  bool has_changed();  // false: the next image need not be drawn; call once a turn
  void wait_for_messages();
  void report_wait();
  bool wants_pixels() const { return !options_.out.empty(); }

  gpu::Device& device_;
  state::PoseState& poses_;
  StreamReceiver& receiver_;
  LiveScene& scene_;
  state::AnimationPlayer* animations_;
  std::optional<state::RobotPose>* robot_;
  // Scene, user edits and joints of the rest pose.
  struct Posed {
    uint64_t scene = UINT64_MAX, edits = 0;
    state::JointPositions joints;
    bool is_at_rest = true;  // as in the file
    bool operator==(const Posed&) const = default;
  };
  Posed posed_;
  state::AnimationClock animation_clock_;                // without a window
  std::optional<AnimationTimeline> animation_timeline_;  // in a window with animations
  CameraRig& camera_;
  sinks::FrameSink& sink_;
  WindowView* window_;
  FrameStats& stats_;
  RendererMetrics* metrics_ = nullptr;
  replay::TimelineControl* timeline_ = nullptr;
  Recording* recording_ = nullptr;
  LiveView* live_view_ = nullptr;
  bool draws_for_viewers_only_ = false;               // nobody receives an image of its own
  std::chrono::steady_clock::time_point animated_{};  // for viewers
  DocumentLoader* next_ = nullptr;
  SceneReload* reload_ = nullptr;
  bool goes_on_ = false;
  ViewerFacts facts_;  // for panels, if there is a window
  const Options& options_;

  gpu::FrameRing frames_;
  passes::SceneRenderer& renderer_;
  std::optional<PathCheckpoint> checkpoint_;  // of path-traced images in files
  capture::CaptureQueue captures_;
  ImageService image_service_;
  VkExtent2D frame_extent_{};   // size of the images that are not requested
  passes::ImageOutputs taken_;  // outputs of each image and their sources
  passes::CameraHistory history_;
  std::optional<uint64_t> instances_listed_;  // LiveScene::replaced() of the listed scene
  uint64_t images_ = 0;                       // drawn images
  uint64_t uncounted_images_ = 0;             // images drawn in a window before the first pose frame
  bool checked_visibility_ = false;
  bool awaits_stream_ = false;      // --wait-for-stream: no pose frame yet
  bool has_undrawn_frame_ = false;  // lockstep: the current pose frame has no image yet
  bool has_due_images_ = false;     // requested images of the current frames are due
  struct Unacknowledged {
    ImageService::Mark drawn;
    std::vector<state::FrameTag> shown;
  };
  std::vector<Unacknowledged> unacknowledged_;  // until the images of these frames are finished
  const std::chrono::steady_clock::time_point started_;
  std::optional<std::chrono::steady_clock::time_point> first_finished_;
  std::chrono::steady_clock::time_point last_image_;
  Progress progress_;
  // Idle runs (has_changed()).
  std::optional<std::array<uint64_t, 3>> drawn_revisions_;    // of poses, scene edits and conditions
  bool has_noted_ = false;                                    // a log line since the last image of a window
  int images_of_change_ = 0;                                  // images to draw until the next change
  std::chrono::steady_clock::time_point changed_ = started_;  // or an image was requested
  std::chrono::steady_clock::time_point lingers_until_ = started_;  // a window is drawn until then
  // Reported waits for streams.
  std::optional<std::chrono::steady_clock::time_point> streamless_since_;
  bool reported_absent_ = false, reported_ended_ = false;
};

}  // namespace fire3dv::app
