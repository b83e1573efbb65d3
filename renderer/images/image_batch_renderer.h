// Renderer of image requests on one device, including read-back. Independent of links. Single-threaded.
#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/readback_ring.h"
#include "renderer/images/image_camera.h"
#include "renderer/images/requested_image.h"
#include "renderer/passes/post/lens_pass.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/state/image_request_registry.h"

namespace fire3dv::app {

inline bool wants_boxes(const wire::ImageRequest& request) {
  return (request.outputs & (wire::kBoxes2d | wire::kBoxes3d)) != 0;
}

// Image requests that this renderer supports. traces_requests: colours by paths, if the renderer traces them;
// otherwise such a renderer offers no colours.
state::ImageAbilities image_abilities(const passes::SceneRenderer& renderer, bool traces_requests = false);

class ImageBatchRenderer {
 public:
  // Borrows both.
  ImageBatchRenderer(gpu::Device& device, passes::SceneRenderer& renderer)
      : device_(device), renderer_(renderer), readback_(device), lens_(device) {}

  struct WorkItem {
    state::ImageRequestRegistry::Due due;
    ImageCamera camera;
  };
  // Poses of the rendered moment, and the boxes of all instances if requested.
  struct Moment {
    const state::PoseState& poses;
    std::shared_ptr<const std::vector<wire::BoxRecord3d>> boxes;
  };

  // Starts a new moment: later images show other poses.
  void begin_moment() { scene_update_ = passes::SceneUpdate::update; }
  // Replaces the work list; compatible images must be adjacent.
  void begin(std::vector<WorkItem>&& work);
  bool has_work() const { return next_ < work_.size(); }
  // Images that are rendered or refused, or whose paths are being traced.
  std::span<const WorkItem> processed() const { return std::span(work_).first(next_); }

  // Limit of one submission: its images stay in host memory until they are sent.
  static constexpr uint64_t kMaxSubmittedBytes = uint64_t{64} << 20;
  // Limits of one submission of several images.
  struct Limits {
    uint64_t bytes = kMaxSubmittedBytes;  // of read-back
    uint64_t cost = std::numeric_limits<uint64_t>::max();
  };
  // Renders some of the images in one submission: at least one, and others within the limits. Returns
  // false if nothing was submitted.
  bool draw(gpu::FrameRing& frames, const Moment& moment, const Limits& limits);
  // True after draw() has begun to trace the paths of an image. Until trace() has ended it, nothing else may
  // be drawn with the renderer, and its scene must stay.
  bool is_tracing() const { return tracing_.has_value(); }
  const state::ImageRequestRegistry::Due& traced() const { return tracing_->work.due; }
  // Adds samples for a short time, and submits the image when it has all of them, or enough for a viewer: it
  // shows the moment of draw(), whatever the poses are now. others_wait: other images are due.
  void trace(gpu::FrameRing& frames, const state::PoseState& poses, bool others_wait = false);
  // Samples of the traced image after the last draw() or trace(); once.
  struct TracedSamples {
    state::RequesterId requester = 0;
    uint64_t request = 0;
    uint32_t samples = 0;
  };
  std::optional<TracedSamples> take_traced_samples() { return std::exchange(traced_samples_, {}); }
  void cancel_tracing();  // of a request that is not open any more
  // Cost of the images rendered since the last call.
  struct Cost {
    uint64_t cost = 0, images = 0;
  };
  Cost take_cost() { return std::exchange(cost_, {}); }
  bool is_blurred(const WorkItem& work) const;  // by depth of field
  // Device memory of the samples that depth of field blurs; 0: the image has none.
  uint64_t lens_bytes(const WorkItem& work) const;
  // Of the image that is drawn next. Precondition: has_work().
  uint64_t next_cost() const { return cost_of(work_[next_]); }
  const WorkItem& next() const { return work_[next_]; }

  // Refuses all remaining images.
  void refuse_rest(const std::string& why);

  // Images rendered but not delivered.
  size_t in_flight() const { return readback_.in_flight(); }
  // Delivers finished images.
  using Take = std::function<void(state::RequesterId requester, const wire::ImageFrame&,
                                  const RequestedImage& pixels)>;
  void deliver(const Take& take);
  // Images whose submissions have ended early, since the last call. They are not delivered.
  std::vector<state::ImageRequestRegistry::Due> take_ended_early() { return std::exchange(ended_early_, {}); }

  // Refusals for lack of device memory since the last call.
  struct Refused {
    state::ImageRequestRegistry::Due due;
    wire::ImageRefusal reason;
    std::string why;
  };
  std::vector<Refused> take_refused() { return std::exchange(refused_, {}); }

  // Drops the state of all requests except these, sorted by requester and id.
  using Key = std::pair<state::RequesterId, uint64_t>;
  void retain_only(std::span<const Key> open);
  // Called for a new scene.
  void clear_histories() { histories_.clear(); }

 private:
  struct Image {
    state::ImageRequestRegistry::Due due;
    wire::ImageFrame frame;
  };
  struct Tag {
    ReadbackViews taken;
    std::vector<Image> images;  // one per view
  };

  // As it is used for this image; a pinhole where it has no colours, or the device cannot blur.
  scene::ThinLens used_lens(const WorkItem& work) const;
  passes::View view_of(const WorkItem& work) const;
  size_t batch_size(std::span<const WorkItem> rest, const Limits& limits) const;
  uint64_t cost_of(const WorkItem& work) const;
  std::optional<passes::PreparedFrame> prepare(std::span<const WorkItem> batch, passes::SceneUpdate scene,
                                               bool refines = false);
  void refuse(std::span<const WorkItem> batch, wire::ImageRefusal reason, const std::string& why);
  void record(const passes::PreparedFrame& prepared, gpu::Recorder& recorder, gpu::StagingRing& staging,
              std::span<const WorkItem> batch, const Moment& moment);
  void read_back(gpu::Recorder& recorder, const passes::ImageOutputs& outputs, Tag&& tag);
  passes::LensPass::Wanted distortion_of(const ImageCamera& camera,
                                         const passes::ImageOutputs& outputs) const;
  // The pinhole image that a lens distorts.
  struct Distorted {
    const passes::ImageOutputs& outputs;
    const passes::View& view;
    const state::PoseState& poses;
  };
  void read_back_through_lens(gpu::Recorder& recorder, gpu::StagingRing& staging, const ImageCamera& camera,
                              const Distorted& image, Tag&& tag);
  std::vector<passes::CameraHistory> take_histories(std::span<const WorkItem> batch);
  void store_histories(std::span<const WorkItem> batch, std::vector<passes::CameraHistory>&& histories);

  // Image whose paths are traced.
  struct Tracing {
    WorkItem work;
    std::shared_ptr<const std::vector<wire::BoxRecord3d>> boxes;
    std::chrono::steady_clock::time_point begun;
    passes::SceneUpdate scene = passes::SceneUpdate::update;
  };
  bool is_traced(bool others_wait) const;

  gpu::Device& device_;
  passes::SceneRenderer& renderer_;
  gpu::ReadbackRing<Tag> readback_;
  passes::LensPass lens_;
  std::vector<WorkItem> work_;
  size_t next_ = 0;  // index of the next image in work_
  Cost cost_;
  passes::SceneUpdate scene_update_ = passes::SceneUpdate::update;
  std::optional<Tracing> tracing_;
  std::optional<TracedSamples> traced_samples_;
  std::vector<Refused> refused_;
  std::vector<state::ImageRequestRegistry::Due> ended_early_;
  const gpu::SubmissionLimits* limits_ = nullptr;   // of the frames of draw()
  std::map<Key, passes::CameraHistory> histories_;  // motion histories of open requests
};

}  // namespace fire3dv::app
