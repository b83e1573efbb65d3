// Optical flow between images of a camera that are some frames apart: which images are drawn for the flow of
// others, and images that wait for the flow to a later one. Frames are drawn once, in order.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "renderer/gpu/readback_ring.h"
#include "renderer/offline/image_set.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::offline {

// Flow of a run.
struct FlowPlan {
  uint32_t frames = 0;         // between two images that are compared; 0: no flow
  uint64_t cameras = 1;        // images of a frame
  bool has_later = true;       // flow to the later image, too
  bool keeps_planes = false;   // images keep the planes of motion and occlusion in place of the flow
  wire::ImageOutputs outputs;  // of an image
  VkExtent2D extent{};

  uint64_t stride() const { return frames * cameras; }
};

// set null: there is none.
FlowPlan plan_flow(const ImageSet* set, uint64_t cameras, VkExtent2D extent);

// Surfaces, depths and poses of the images between two that are compared stay on the device, the images
// themselves in memory. Error if their limits do not allow it. snapshot_bytes: poses of an image.
Result<void> check_flow_memory(const FlowPlan& plan, uint64_t snapshot_bytes);

class FlowImages {
 public:
  // images: of the whole run.
  FlowImages(gpu::Device& device, uint64_t images, const FlowPlan& plan)
      : images_(images),
        stride_(plan.stride()),
        has_later_(plan.has_later),
        keeps_planes_(plan.keeps_planes),
        readback_(device) {}

  // Images before and after a wanted one that are drawn for its flow.
  uint64_t reach_before() const { return stride_; }
  uint64_t reach_after() const { return has_later_ ? stride_ : 0; }
  // Whether images have flow to a later one, for which their surfaces are kept.
  bool has_later() const { return has_later_; }
  // Outputs of an image that is wanted by itself, beside those that it has anyway.
  uint32_t further_outputs() const {
    return keeps_planes_ ? 0 : uint32_t{wire::kMotion} | uint32_t{wire::kOcclusionU32};
  }
  // Whether an image is drawn, for itself or for the flow of one that is wanted.
  bool is_needed(uint64_t image, const std::function<bool(uint64_t image)>& is_wanted) const;

  // The image that the one which is drawn next is compared with. Null: it was not drawn, or of another
  // scene. scene: LiveScene::replaced().
  std::shared_ptr<const passes::CameraHistory> earlier(uint64_t image, uint64_t scene) const;
  // After the renderer has recorded an image with its history. is_wanted: pixels of it follow.
  void recorded(gpu::Recorder& recorder, passes::SceneRenderer& renderer, uint64_t image, uint64_t scene,
                const passes::CameraHistory& history, bool is_wanted);
  void submitted(uint64_t timeline_value) { readback_.submitted(timeline_value); }

  // An image with its motion and occlusion planes, which become the flow to the earlier one. Error if the
  // waiting images take too much memory.
  Result<void> add(sinks::FrameImage&& image);
  // Hands over the images that have all their flow, in order.
  Result<void> deliver(sinks::FrameSink& sink);

 private:
  struct Drawn {
    std::shared_ptr<const passes::CameraHistory> history;
    uint64_t scene = 0;
  };
  struct Waiting {
    bool has_earlier = false, awaits_later = false;
    std::optional<sinks::FrameImage> image;
    std::optional<sinks::Flow> forward;
  };

  uint64_t images_, stride_;
  bool has_later_, keeps_planes_;
  std::map<uint64_t, Drawn> drawn_;      // the last ones of each camera
  std::map<uint64_t, Waiting> waiting_;  // wanted images that are not handed over
  uint64_t waiting_bytes_ = 0;
  gpu::ReadbackRing<uint64_t> readback_;  // flow to the later image, of the image with this number
};

}  // namespace fire3dv::offline
