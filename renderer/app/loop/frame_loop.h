// Frame loop of the renderer: polls streams and input, renders, and delivers images.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/process/progress.h"
#include "protocol/replay/replay_clock.h"
#include "renderer/app/document.h"
#include "renderer/app/frame_stats.h"
#include "renderer/app/loop/idle_detection.h"
#include "renderer/app/loop/path_checkpoint.h"
#include "renderer/app/loop/rest_motion.h"
#include "renderer/app/loop/stream_wait.h"
#include "renderer/app/loop/view_motion.h"
#include "renderer/app/options/options.h"
#include "renderer/app/recording.h"
#include "renderer/app/renderer_metrics.h"
#include "renderer/browser/live_view.h"
#include "renderer/camera/camera_rig.h"
#include "renderer/capture/capture.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/images/image_service.h"
#include "renderer/images/secondary_devices.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/loading/scene_reload.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"
#include "renderer/state/motion/animation.h"
#include "renderer/state/robot_pose.h"
#include "renderer/streams/stream_receiver.h"
#include "renderer/window/window_panels.h"
#include "renderer/window/window_view.h"

namespace fire3dv::app {

// Objects that a frame loop works with. All are borrowed.
struct FrameLoopContext {
  gpu::Device& device;
  passes::SceneRenderer& renderer;  // has its scene
  state::PoseState& poses;
  StreamReceiver& receiver;
  ImageRequestQueue& requests;
  LiveScene& scene;
  CameraRig& camera;
  sinks::FrameSink& sink;
  FrameStats& stats;
  SecondaryDevices& secondary_devices;     // render image requests, too
  const settings::DrawSettings& settings;  // current ones, for secondary devices
  const Options& options;
  std::optional<state::RobotPose>& robot;  // of the file; empty: nobody moves its joints
  // Null: there is none.
  state::AnimationPlayer* animations = nullptr;
  WindowView* window = nullptr;
  LiveView* live_view = nullptr;
  RendererMetrics* metrics = nullptr;
  replay::TimelineControl* timeline = nullptr;
  Recording* recording = nullptr;
  DocumentLoader* next = nullptr;  // a loaded document ends run()
  SceneReload* reload = nullptr;
  std::shared_ptr<const std::string> provenance = nullptr;  // of the run, for images in files
};

class FrameLoop {
 public:
  explicit FrameLoop(const FrameLoopContext& context);

  // Interrupted path-traced images of a run without a window continue from a checkpoint. Call before run().
  Result<void> open_checkpoint();
  Result<void> run();
  bool switches_document() const { return switches_document_; }  // true if run() ended for the next scene
  uint64_t images() const { return images_; }

 private:
  void log_technique() const;
  void log_motion() const;
  BrowserNumbers browser_numbers() const;
  bool done();
  Result<void> await_stream();  // clears awaits_stream_ at the first pose frame; fails after the timeout
  void log_notes();
  bool poll_streams();  // polls streams; true if there is a new pose frame
  void steer();         // applies user input
  void show_markers();
  Result<void> draw();
  passes::PathHooks path_hooks(const passes::View& view, Progress& progress);
  void report_stopped_paths() const;
  bool refines() const;  // the window's image lacks path-traced samples
  Result<void> finish_served(const ImageService::Drawn& served);
  Result<void> wait_for_slot();
  Result<void> deliver();  // passes finished images to the sink
  Result<void> list_instances();
  Result<void> write_instance_file();
  void report_slow_start(uint64_t done_at);
  void warn_of_empty_image(const passes::View& view, const std::vector<state::FrameTag>& shown);
  void note_cost(const std::vector<state::FrameTag>& shown, std::chrono::steady_clock::time_point begun);
  bool is_in_motion(const passes::View& view);
  bool has_changed();  // false: the next image need not be drawn; call once a turn
  void wait_for_messages();
  bool wants_pixels() const { return !context_.options.out.empty(); }

  const FrameLoopContext context_;
  RestMotion motion_;
  StreamWait stream_wait_;
  IdleDetection idle_;
  ViewMotion view_motion_;
  bool draws_for_browsers_only_ = false;  // nobody receives an image of its own
  bool switches_document_ = false;
  PanelFacts facts_;  // for panels, if there is a window

  gpu::FrameRing frames_;
  std::optional<PathCheckpoint> checkpoint_;  // of path-traced images in files
  capture::CaptureQueue captures_;
  ImageService image_service_;
  PeerDrawTime draw_time_;
  VkExtent2D frame_extent_{};   // size of the images that are not requested
  passes::ImageOutputs taken_;  // outputs of each image and their sources
  passes::CameraHistory history_;
  std::optional<uint64_t> instances_listed_, instance_file_written_;  // LiveScene::replaced() of the scene
  uint64_t images_ = 0;                                               // drawn images
  uint64_t uncounted_images_ = 0;  // images drawn in a window before the first pose frame
  bool checked_visibility_ = false;
  bool awaits_stream_ = false;      // --wait-for-stream: no pose frame yet
  bool has_undrawn_frame_ = false;  // lockstep: the current pose frame has no image yet
  bool has_due_images_ = false;     // requested images of the current frames are due
  struct Unacknowledged {
    ImageService::Mark drawn;
    std::vector<state::FrameTag> shown;
  };
  std::vector<Unacknowledged> unacknowledged_;  // until the images of these frames are finished
  std::optional<std::chrono::steady_clock::time_point> first_finished_;
  std::chrono::steady_clock::time_point last_image_;
  Progress progress_;
  bool has_noted_ = false;  // a log line since the last image of a window
};

}  // namespace fire3dv::app
