// The frame loop: what adapters sent, what to show of it, drawing it, handing it on.
#pragma once

#include <chrono>
#include <utility>
#include <vector>

#include "protocol/replay/timeline.h"
#include "renderer/app/animation_clock.h"
#include "renderer/app/camera_rig.h"
#include "renderer/app/frame_planes.h"
#include "renderer/app/frame_stats.h"
#include "renderer/app/image_service.h"
#include "renderer/app/live_scene.h"
#include "renderer/app/options.h"
#include "renderer/app/progress.h"
#include "renderer/app/recording.h"
#include "renderer/app/renderer_metrics.h"
#include "renderer/app/show.h"
#include "renderer/app/stream_intake.h"
#include "renderer/app/viewer_facts.h"
#include "renderer/app/window_view.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/passes/readback_belt.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"
#include "renderer/state/animation.h"

namespace fire3dv::app {

// Set by SIGINT and SIGTERM, once install_stop_signals() was called: the loop ends in order.
void install_stop_signals();
bool stop_was_requested();

// How the options want scenes drawn. environment: null for the studio.
passes::DrawSettings draw_settings(const Options& options,
                                   std::shared_ptr<const scene::EnvironmentImage> environment);

class FrameLoop {
 public:
  // All is borrowed. The renderer has its scene. window may be null; so may animations, where none play.
  FrameLoop(gpu::Device& device, passes::SceneRenderer& renderer, state::PoseState& poses,
            StreamIntake& intake, LiveScene& scene, state::AnimationPlayer* animations, CameraRig& camera,
            sinks::FrameSink& sink, WindowView* window, FrameStats& stats, const Options& options);

  // Borrowed; null: nobody wants to know. Before run().
  void report_to(RendererMetrics* metrics) { metrics_ = metrics; }
  // Borrowed; null: nothing is replayed, or recorded. Before run().
  void follow(replay::TimelineControl* timeline) { timeline_ = timeline; }
  void record_with(Recording* recording) { recording_ = recording; }
  // Borrowed: these draw images for simulators, too, as the settings say at any time. Before run().
  void spread_images_over(FurtherDevices& further, const passes::DrawSettings& settings) {
    image_service_.spread_over(further, settings);
  }
  // Ends run() when it is ready.
  void go_on_with(NextShow* next) { next_ = next; }
  Result<void> run();
  bool goes_on() const { return goes_on_; }  // with that one: it is why run() has ended
  uint64_t images() const { return images_; }

 private:
  struct ImageTag {
    uint64_t frame_index;
    std::string camera;
    std::vector<state::FrameTag> shown;
    TakenPlanes planes;
  };
  bool done();
  Result<void> await_stream();  // clears awaits_stream_ at the first pose frame; fails after the time-out
  void say_notes();
  bool take_in();  // what adapters have sent; true when there is a pose frame to show
  void steer();    // by the user
  void animate();
  void draw();
  void read_back(gpu::Recorder& recorder, ImageTag tag);
  Result<void> finish_served(bool served);
  Result<void> deliver();  // finished images to the sink
  Result<void> hand_over(ImageTag tag, VkExtent2D extent, std::span<const uint8_t> pixels);
  Result<void> list_instances();
  void note_cost(const std::vector<state::FrameTag>& shown, std::chrono::steady_clock::time_point begun);
  bool wants_pixels() const { return !options_.out.empty(); }

  gpu::Device& device_;
  state::PoseState& poses_;
  StreamIntake& intake_;
  LiveScene& scene_;
  state::AnimationPlayer* animations_;
  AnimationClock animation_clock_;
  CameraRig& camera_;
  sinks::FrameSink& sink_;
  WindowView* window_;
  FrameStats& stats_;
  RendererMetrics* metrics_ = nullptr;
  replay::TimelineControl* timeline_ = nullptr;
  Recording* recording_ = nullptr;
  NextShow* next_ = nullptr;
  bool goes_on_ = false;
  ViewerFacts facts_;  // for panels, where there is a window
  const Options& options_;

  gpu::FrameRing frames_;
  passes::SceneRenderer& renderer_;
  passes::ReadbackBelt<ImageTag> readback_;
  ImageService image_service_;
  VkExtent2D own_extent_{};     // of the images that are drawn unasked
  passes::ImageOutputs taken_;  // of each image: what is wanted, and what that is made of
  passes::CameraHistory history_;
  std::optional<uint64_t> instances_listed_;  // LiveScene::replaced() of the list's scene
  uint64_t images_ = 0;                       // drawn
  uint64_t uncounted_images_ = 0;             // drawn in a window before the first pose frame
  bool awaits_stream_ = false;                // --wait-for-stream: no pose frame has come yet
  bool undrawn_ = false;  // lockstep: a pose frame is shown that no image has been drawn of yet
  struct Unacknowledged {
    ImageService::Mark drawn;
    std::vector<state::FrameTag> shown;
  };
  std::vector<Unacknowledged> unacknowledged_;  // until what was drawn of these frames is done
  const std::chrono::steady_clock::time_point started_;
  std::optional<std::chrono::steady_clock::time_point> first_finished_;
  std::chrono::steady_clock::time_point last_image_;
  Progress progress_;
};

}  // namespace fire3dv::app
