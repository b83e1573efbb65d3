// Draws the scene's clusters by compute for one set of views: culled, small triangles at once, large ones in
// tiles. The camera's set covers samples of the visibility buffer, the lights' set texels of their maps.
// Several sets run through the stages side by side, since each stage ends in a barrier.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipeline.h"
#include "renderer/passes/gpu_scene.h"

namespace fire3dv::passes {

enum class RasterKind : uint8_t { camera_1_sample, camera_4_samples, lights };

class ClusterRaster {
 public:
  ClusterRaster(gpu::Device& device, VkPipelineLayout layout, RasterKind kind);

  // What one frame draws. views: RasterView[view_count]; target: see gpu_types::RasterSet.
  struct Job {
    GpuScene* scene = nullptr;
    gpu::Buffer* views_written = nullptr;  // null when the views were uploaded
    gpu::Buffer* target = nullptr;
    VkDeviceAddress views = 0;
    VkDeviceAddress globals = 0;
    uint32_t view_count = 1;
    bool cull = true;
  };
  // Sizes the lists for the job and uploads what the stages share.
  void begin(gpu::UploadBelt& belt, const Job& job);

  // Records all stages of several sets.
  static void record(gpu::Recorder& recorder, std::span<ClusterRaster* const> sets);

 private:
  void make_room(const Job& job);
  void add_uses(std::vector<gpu::Use>& uses, bool large);
  void clear(VkCommandBuffer commands);
  void bind(VkCommandBuffer commands, const gpu::Pipeline& pipeline, uint32_t view) const;
  void cull(VkCommandBuffer commands) const;
  void raster(VkCommandBuffer commands) const;
  void large_stage(VkCommandBuffer commands, const gpu::Pipeline& pipeline, VkDeviceSize arguments) const;

  gpu::Device& device_;
  VkPipelineLayout layout_;
  gpu::Pipeline cull_, raster_, raster_mask_, expand_, tiles_;
  Job job_;
  VkDeviceAddress set_ = 0;
  gpu::Buffer work_, lists_, large_, huge_, prepared_, tile_entries_;
  std::array<gpu::Buffer, gpu::kFramesInFlight> large_seen_;  // the same slot's last LargeWork
  uint64_t frame_ = 0;
  uint32_t huge_capacity_ = 1u << 16;
};

}  // namespace fire3dv::passes
