// Compute rasteriser of clusters for one set of views: cull, raster of small triangles, tiled raster of large
// ones. The camera's set writes the visibility buffer, the lights' set their shadow maps. Several sets share
// each stage, since each stage ends in a barrier.
//
// Two-pass occlusion culling: the early round draws clusters visible in the last frame. The late
// (disocclusion) round draws the other clusters that pass the HiZ test. The image does not depend on earlier
// visibility.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/settings/raster_settings.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// lights_center_only: shadow maps without outer maps. camera_counts: triangle count at each pixel's centre.
enum class RasterKind : uint8_t {
  camera_1_sample,
  camera_4_samples,
  camera_counts,
  lights,
  lights_center_only
};
constexpr bool is_of_lights(RasterKind kind) {
  return kind == RasterKind::lights || kind == RasterKind::lights_center_only;
}

// Number of tiles of an image for large triangles.
VkExtent2D tiles_of(VkExtent2D extent);

class ClusterRaster {
 public:
  ClusterRaster(gpu::Device& device, VkPipelineLayout layout, RasterKind kind);

  // One frame's work. views: RasterView[view_count]; target: see gpu_types::RasterSet.
  struct Job {
    GpuScene* scene = nullptr;
    gpu::Buffer* views_written = nullptr;  // null when the views were uploaded
    ClusterTarget* target = nullptr;       // begin(target_bytes) was called
    VkDeviceSize target_bytes = 0;
    VkDeviceAddress views = 0;
    VkDeviceAddress globals = 0;  // of all views
    // Instead, of each view, where the views are drawn in common dispatches.
    std::vector<VkDeviceAddress> globals_of_views;
    uint32_t view_count = 1;
    VkExtent2D extent{};  // of the camera's image, or of the largest shadow map
    settings::Cull cull = settings::Cull::automatic;
    bool levels_of_detail = false;  // false: LOD 0 clusters only

    bool is_common() const { return !globals_of_views.empty(); }
    uint32_t instance_count() const {
      return levels_of_detail ? scene->cluster_instance_count : scene->lod0_cluster_instance_count;
    }
  };
  // Starts compilation of the pipelines for alpha-masked scenes, if missing.
  void expect_masks();
  // The same for those that draw all views in common dispatches.
  void expect_common(bool masks);
  // Sizes the lists for the job.
  void allocate(const Job& job);
  // Calls allocate and uploads the stages' common parameters.
  void begin(gpu::StagingRing& staging, const Job& job);

  // Cluster counts of the first view in a finished frame.
  struct Drawn {
    uint32_t clusters = 0;
    uint32_t late_clusters = 0;  // of these, drawn in the second round
  };
  const Drawn& drawn() const { return drawn_; }

  // Clear of the lists and targets of begun sets. It may overlap with another pass of the frame.
  struct Clear {
    std::vector<gpu::Use> uses;
    std::function<void(VkCommandBuffer)> commands;
  };
  static Clear clear_of(std::span<ClusterRaster* const> sets);
  // Records all stages of several cleared sets.
  static void record(gpu::Recorder& recorder, std::span<ClusterRaster* const> sets);

 private:
  VkDeviceSize tile_list_bytes(const Job& job) const;
  void add_uses(std::vector<gpu::Use>& uses);
  void clear(VkCommandBuffer commands);
  void bind(VkCommandBuffer commands, const gpu::Pipeline& pipeline, uint32_t round, uint32_t view) const;
  uint32_t cull_groups() const;
  VkDeviceSize clear_quads(uint32_t round) const;
  void cull(VkCommandBuffer commands, uint32_t round) const;
  bool is_narrow() const;
  void raster(VkCommandBuffer commands, uint32_t round) const;
  void large_stage(VkCommandBuffer commands, const gpu::Pipeline& pipeline, uint32_t round,
                   VkDeviceSize arguments) const;
  void draw_tiles(VkCommandBuffer commands, uint32_t round) const;
  void build_hiz(VkCommandBuffer commands) const;
  static void record_round(gpu::Recorder& recorder, std::span<ClusterRaster* const> sets, uint32_t round);
  bool culls_occluded(const Job& job) const;
  void read_counts();
  void keep_counts(gpu::Recorder& recorder);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  const RasterKind kind_;
  const bool tile_by_tile_;  // on a CPU: one workgroup per tile of the image, not per triangle
  struct LargePipelines {
    gpu::Pipeline expand, tiles;
  };
  // common: for several views in one dispatch.
  void make_cull(bool common, gpu::Compile when);
  void make_raster(bool masks, bool common, gpu::Compile when);
  void make_large(bool masks, bool common, gpu::Compile when);
  const LargePipelines& large() const {
    return pipelines_.large[job_.scene->has_masked ? 1 : 0][job_.is_common() ? 1 : 0];
  }

  struct Pipelines {
    gpu::Pipeline hiz;
    gpu::Pipeline cull[2], raster[2], raster_narrow[2], raster_mask[2];  // one view a dispatch; all views
    // Large masked triangles need pipelines with an alpha test; most scenes have none. Second index as in
    // cull.
    LargePipelines large[2][2];
  };
  Pipelines pipelines_;
  Job job_;
  uint32_t round_count_ = 1;
  std::array<VkDeviceAddress, 2> round_sets_{};  // RasterSet
  gpu::Buffer work_;                             // LargeWork and ViewWork of each round
  gpu::Buffer lists_, huge_, prepared_, tile_entries_;
  gpu::Buffer tile_lists_, tile_next_;  // per-tile raster only
  gpu::Buffer was_visible_, hiz_;
  bool was_visible_is_new_ = true;                               // was_visible_ is new
  std::array<gpu::Buffer, gpu::kFramesInFlight> counts_;         // counters of the slot's last frame
  std::array<uint32_t, gpu::kFramesInFlight> rounds_counted_{};  // by that frame; 0: nothing yet
  Drawn drawn_;
  uint32_t clusters_in_view_ = 0,
           clusters_not_occluded_ = 0;  // of the last frames with one round and with two
  uint64_t frame_ = 0;
  uint32_t huge_capacity_ = 1u << 16;
};

}  // namespace fire3dv::passes
