// Layers of blended draws: composites their fragments pixel by pixel in the order of their depths, whatever
// the order of the draws. The image does not depend on the device's order of fragments. See
// docs/design/transparency.md.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/gpu/recorder.h"
#include "renderer/passes/resources/targets.h"

namespace fire3dv::passes {

// One of the two times that a pass draws. Recorded within `rendering`, which batches may end and begin again.
struct LayerStep {
  enum class Stage : uint8_t { keys, light };
  Stage stage;
  uint32_t pass;           // of FIRE3DV_LAYER_PASSES
  VkDeviceAddress target;  // gpu_types::LayerTarget
  // Number of draws, for vkCmdDrawIndexedIndirectCount: all or none.
  VkBuffer draw_count;
  VkDeviceSize draw_count_offset;
  const VkRenderingInfo& rendering;
};

// Blended draws of one source, with what they read.
struct LayerDraws {
  std::vector<gpu::Use> uses;
  std::function<void(VkCommandBuffer, const LayerStep&)> record;
};

class LayerPass {
 public:
  // layout: with push constants. samples: of the HDR target.
  LayerPass(gpu::Device& device, VkPipelineLayout layout, VkSampleCountFlagBits samples);

  static bool is_supported(const gpu::Device& device) { return device.report().sorted_fragments; }

  // Allocates memory for images of this size: less than 256 MiB, and less where the device has less. Images
  // with more pixels are drawn in several rectangles, with the same bytes.
  void allocate(VkExtent2D extent);

  // Draws over the colours in targets.hdr, before the depths in targets.depth.
  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, Targets& targets, const VkRect2D& area,
              std::span<const LayerDraws> draws);

 private:
  VkDeviceAddress upload_target(gpu::StagingRing& staging, const VkRect2D& part) const;
  void record_part(VkCommandBuffer commands, const Targets& targets, const VkRect2D& part,
                   VkDeviceAddress target, std::span<const LayerDraws> draws) const;
  void composite(VkCommandBuffer commands, VkDeviceAddress target, uint32_t pass, uint32_t pixels) const;
  void resolve(VkCommandBuffer commands, const Targets& targets, const VkRect2D& part,
               VkDeviceAddress target) const;

  gpu::Device& device_;
  VkPipelineLayout layout_;
  VkSampleCountFlagBits samples_;
  gpu::Pipeline composite_, resolve_;
  uint64_t capacity_px_ = 0;
  VkDeviceSize wanted_bytes_ = 0;  // of the last allocation; the device may have had less
  gpu::Buffer keys_;               // keys and rests, zero between images
  gpu::Buffer layers_;             // states, samples and records of a rectangle
  gpu::Buffer work_;               // gpu_types::LayerWork[FIRE3DV_LAYER_PASSES]
  bool are_keys_zero_ = false;
};

}  // namespace fire3dv::passes
