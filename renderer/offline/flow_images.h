// Optical flow between images of a camera that are some frames apart: which images are drawn for the flow of
// others, and images that wait for the flow to a later one. Frames are drawn once, in order.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "renderer/gpu/readback_ring.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::offline {

// Surfaces of the images between two that are compared stay on the device, within its limit.
Result<void> check_flow_memory(uint32_t flow_frames, uint64_t cameras, VkExtent2D extent);

class FlowImages {
 public:
  // images: of the whole run. stride: number of images between two that are compared.
  FlowImages(gpu::Device& device, uint64_t images, uint64_t stride)
      : images_(images), stride_(stride), readback_(device) {}

  uint64_t stride() const { return stride_; }
  // Whether an image is drawn, for itself or for the flow of one that is wanted.
  bool is_needed(uint64_t image, const std::function<bool(uint64_t image)>& is_wanted) const;

  // The image that the one which is drawn next is compared with. Null: it was not drawn, or of another
  // scene. scene: LiveScene::replaced().
  std::shared_ptr<const passes::CameraHistory> earlier(uint64_t image, uint64_t scene) const;
  // After the renderer has recorded an image with its history. is_wanted: pixels of it follow.
  void recorded(gpu::Recorder& recorder, passes::SceneRenderer& renderer, uint64_t image, uint64_t scene,
                const passes::CameraHistory& history, bool is_wanted);
  void submitted(uint64_t timeline_value) { readback_.submitted(timeline_value); }

  // An image with its motion and occlusion planes, which become the flow to the earlier one.
  void add(sinks::FrameImage&& image);
  // Hands over the images that have both flows, in order.
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
  std::map<uint64_t, Drawn> drawn_;       // the last ones of each camera
  std::map<uint64_t, Waiting> waiting_;   // wanted images that are not handed over
  gpu::ReadbackRing<uint64_t> readback_;  // flow to the later image, of the image with this number
};

}  // namespace fire3dv::offline
