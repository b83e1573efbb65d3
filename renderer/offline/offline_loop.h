// Scene and render loop of an offline run: renders the frames of a recording at full speed. Frames in flight
// keep the device busy; the sink encodes finished images on its own threads.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "protocol/record/playback.h"
#include "renderer/app/loop/path_checkpoint.h"
#include "renderer/app/options/options.h"
#include "renderer/app/recording.h"
#include "renderer/camera/camera_rig.h"
#include "renderer/capture/capture.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/images/following_renderer.h"
#include "renderer/live_scene/live_scene.h"
#include "renderer/loading/scene_load.h"
#include "renderer/offline/flow_images.h"
#include "renderer/offline/image_set.h"
#include "renderer/offline/recorded_streams.h"
#include "renderer/offline/timeline.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/cache/scene_cache.h"
#include "renderer/sinks/frame.h"
#include "renderer/state/motion/animation.h"
#include "renderer/state/robot_pose.h"

namespace fire3dv::offline {

// Scene of an offline run: the file named by the user, else the scene stored in the recording. No text of the
// recording is used as a path.
class RecordingScene {
 public:
  // Starts loading. If there is no scene, the error suggests one.
  // playback null: there is no recording, and the options name a scene.
  static Result<std::unique_ptr<RecordingScene>> open(const app::Options& options,
                                                      const scene::SceneCacheSettings& cache,
                                                      record::Playback* playback,
                                                      std::function<bool()> should_stop);

  const std::string& title() const { return title_; }  // for messages
  app::SceneLoad& load() { return *load_; }
  // The error with the title in place of the temporary file.
  Error with_title(Error error) const {
    return recorded_ ? recorded_->with_name(std::move(error), recording_) : error;
  }

 private:
  RecordingScene() = default;

  std::string title_, recording_;
  std::unique_ptr<app::RecordedScene> recorded_;  // set if the recording stores the scene
  std::optional<app::SceneLoad> load_;
};

class OfflineLoop {
 public:
  // All members are borrowed. streams null: there is no recording. animations null: none play. cameras: at
  // least one. checkpoint null: of no path-traced image. robot: of the scene's file; its joints have the
  // positions of the user's edits. null: none is moved. set null: colours of one camera.
  struct Parts {
    gpu::Device& device;
    passes::SceneRenderer& renderer;
    // Images go round the devices, the first one included.
    std::span<const std::unique_ptr<app::FollowingRenderer>> secondary;
    std::shared_ptr<const scene::EnvironmentImage> environment;  // of the renderer's settings; null: none
    state::PoseState& poses;
    RecordedStreams* streams;
    app::LiveScene& scene;
    std::optional<state::AnimationPlayer>* animations;
    std::span<app::CameraRig> cameras;
    sinks::FrameSink& sink;
    app::PathCheckpoint* checkpoint = nullptr;
    state::RobotPose* robot = nullptr;
    ImageSet* set = nullptr;
    // Puts a renderer with the environment image of the settings in the place of `renderer`. Needed by
    // changes of the set.
    std::function<Result<void>(const settings::DrawSettings&)> replace_renderer = {};
    bool markers = true;
    std::vector<std::shared_ptr<const std::string>> provenance = {};  // of the run, by device; null: none
  };
  OfflineLoop(const Parts& parts, const FrameTimes& times);

  // Renders the images of the part for which is_wanted is true. Returns false if should_stop ended it early.
  Result<bool> run(const Part& part, const std::function<bool(uint64_t image)>& is_wanted,
                   const std::function<bool()>& should_stop);
  uint64_t images() const { return images_; }

 private:
  struct DrawingDevice {
    DrawingDevice(gpu::Device& on, passes::SceneRenderer& with, app::FollowingRenderer* as)
        : device(on), renderer(with), following(as), frames(on), captures(on) {}
    gpu::Device& device;
    passes::SceneRenderer& renderer;
    app::FollowingRenderer* following;  // null: the first device
    std::shared_ptr<const std::string> provenance;
    gpu::FrameRing frames;
    capture::CaptureQueue captures;
  };
  Result<void> advance(uint64_t frame);
  Result<void> change(uint64_t frame, bool is_new_scene, const state::RestPose& rest);
  void pose(state::RestPose rest);
  // Returns false if should_stop ended it.
  // is_wanted: else it is drawn for the flow of others.
  Result<bool> draw(uint64_t image, bool is_wanted, const std::function<bool()>& should_stop);
  wire::ImageOutputs outputs_of_image() const;
  passes::FrameRequest request_of(uint64_t image, bool is_wanted) const;
  void capture(DrawingDevice& on, gpu::Recorder& recorder, uint64_t image, const passes::View& view,
               const app::CameraRig::Placed& camera);
  app::CameraRig::Placed place(uint64_t image, size_t camera) const;
  Result<void> deliver();

  // The next device, with scene, edits, markers and settings of the moment.
  Result<DrawingDevice*> next_device();

  Parts parts_;
  FrameTimes times_;
  std::vector<std::unique_ptr<DrawingDevice>> devices_;
  uint64_t drawn_ = 0;                             // images, also those for the flow of others
  std::deque<uint64_t> undelivered_;               // images, in the order of the sink
  std::map<uint64_t, sinks::FrameImage> arrived_;  // of those
  std::optional<FlowImages> flow_;
  uint64_t images_ = 0;
  std::optional<uint64_t> posed_scene_;  // number of the scene that has its rest pose
  ImageChanges* const changes_;          // null: none
  state::UserEdits unchanged_edits_;
  settings::DrawSettings unchanged_settings_;
  settings::DrawSettings current_settings_;  // of secondary devices, with the environment
};

}  // namespace fire3dv::offline
