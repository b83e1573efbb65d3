// Draws surfaces that the visibility buffer lacks, with its coverage rules: silhouettes of instances as if
// each were alone, and blended surfaces for the labels.
#pragma once

#include <span>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/scene/model/scene_edits.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

class SilhouettesPass {
 public:
  // samples: 1 or 4, of the visibility buffer.
  SilhouettesPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples);

  // What is drawn.
  struct Shown {
    const scene::Scene& scene;
    const GpuScene& gpu_scene;
    float label_alpha;                         // blended surfaces with more alpha have labels
    const scene::SceneEdits* edits = nullptr;  // null: none
  };
  struct Source {
    Shown shown;
    GpuScene& gpu_scene;
    gpu::Buffer& visibility;
    std::span<const VkDeviceAddress> globals;  // per view
    VkExtent2D extent;                         // of a view
  };

  // Frees what overlay_blended() has allocated for the last scene.
  void set_scene() { labelled_ = {}; }
  // Allocates what overlay_blended() of such images needs. Edits of the frame may still change that;
  // overlay_blended() then allocates it.
  void make_room(const Shown& shown, VkExtent2D extent, uint32_t views);
  // Returns a copy of the visibility buffer with the blended surfaces, or null if none can have a label.
  // Borrowed until the next call.
  gpu::Buffer* overlay_blended(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source);

  // Memory of the bits, see silhouettes.h.
  struct Bits {
    gpu::Buffer& buffer;
    VkDeviceSize offset, bytes;
  };
  // Draws all instances of one view's world.
  void draw(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source, const Bits& bits);

 private:
  VkDeviceSize view_bytes(VkExtent2D extent) const;
  void dispatch(gpu::Recorder& recorder, gpu::StagingRing& staging, const char* name, GpuScene& scene,
                gpu::Buffer& written, std::span<const gpu_types::SilhouettesWanted> wanted);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Buffer labelled_;  // the copy
  uint32_t samples_;
};

}  // namespace fire3dv::passes
