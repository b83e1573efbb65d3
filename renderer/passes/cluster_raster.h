// Draws the scene's clusters by compute for one set of views: culled, small triangles at once, large ones in
// tiles. The camera's set covers samples of the visibility buffer, the lights' set texels of their maps.
// Several sets run through the stages side by side, since each stage ends in a barrier.
//
// Where hidden clusters are left out there are two rounds: what was seen in the frame before is drawn early,
// what is not hidden behind that is drawn late. The image is the same whatever was seen before.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipeline.h"
#include "renderer/passes/cluster_target.h"
#include "renderer/passes/gpu_scene.h"

namespace fire3dv::passes {

// lights_middles: lights' maps without the outer ones. camera_counts: of each pixel's middle, how many
// triangles cover it.
enum class RasterKind : uint8_t { camera_1_sample, camera_4_samples, camera_counts, lights, lights_middles };
constexpr bool is_of_lights(RasterKind kind) {
  return kind == RasterKind::lights || kind == RasterKind::lights_middles;
}

// What is left out of drawing. The image is the same with all of them.
enum class Cull : uint8_t {
  off,
  view,       // what is outside the view, turned away or between samples
  hidden,     // that, and what is behind other things
  automatic,  // hidden in large scenes, for as long as it leaves out much
};

// Into which an image is cut for large triangles.
VkExtent2D tiles_of(VkExtent2D extent);

class ClusterRaster {
 public:
  ClusterRaster(gpu::Device& device, VkPipelineLayout layout, RasterKind kind);

  // What one frame draws. views: RasterView[view_count]; target: see gpu_types::RasterSet.
  struct Job {
    GpuScene* scene = nullptr;
    gpu::Buffer* views_written = nullptr;  // null when the views were uploaded
    ClusterTarget* target = nullptr;       // that has begun with target_bytes
    VkDeviceSize target_bytes = 0;
    VkDeviceAddress views = 0;
    VkDeviceAddress globals = 0;
    uint32_t view_count = 1;
    VkExtent2D extent{};  // of the camera's image, or of the lights' largest map
    Cull cull = Cull::automatic;
    bool levels_of_detail = false;  // false: the file's own clusters alone

    uint32_t instance_count() const {
      return levels_of_detail ? scene->cluster_instance_count : scene->own_cluster_instance_count;
    }
  };
  // Begins to make what scenes with alpha-masked surfaces need, if it is not made yet.
  void expect_masks();
  // Sizes the lists for the job.
  void make_room(const Job& job);
  // That, and uploads what the stages share.
  void begin(gpu::UploadBelt& belt, const Job& job);

  // Of the first view, in a frame that is finished.
  struct Drawn {
    uint32_t clusters = 0;
    uint32_t late_clusters = 0;  // of them those of the second round
  };
  const Drawn& drawn() const { return drawn_; }

  // Of sets that have begun: what empties their lists and targets. It can go beside another pass of the
  // frame.
  struct Emptying {
    std::vector<gpu::Use> uses;
    std::function<void(VkCommandBuffer)> commands;
  };
  static Emptying emptying(std::span<ClusterRaster* const> sets);
  // Records all stages of several sets that are empty.
  static void record(gpu::Recorder& recorder, std::span<ClusterRaster* const> sets);

 private:
  VkDeviceSize tile_list_bytes(const Job& job) const;
  void add_uses(std::vector<gpu::Use>& uses);
  void clear(VkCommandBuffer commands);
  void bind(VkCommandBuffer commands, const gpu::Pipeline& pipeline, uint32_t round, uint32_t view) const;
  uint32_t cull_groups() const;
  VkDeviceSize clear_quads(uint32_t round) const;
  void cull(VkCommandBuffer commands, uint32_t round) const;
  void raster(VkCommandBuffer commands, uint32_t round) const;
  void large_stage(VkCommandBuffer commands, const gpu::Pipeline& pipeline, uint32_t round,
                   VkDeviceSize arguments) const;
  void draw_tiles(VkCommandBuffer commands, uint32_t round) const;
  void find_farthest(VkCommandBuffer commands) const;
  static void record_round(gpu::Recorder& recorder, std::span<ClusterRaster* const> sets, uint32_t round);
  bool leaves_out_hidden(const Job& job) const;
  void read_counts();
  void keep_counts(gpu::Recorder& recorder);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  const RasterKind kind_;
  const bool tile_by_tile_;  // on a CPU: a workgroup for each tile of the image, not of each triangle
  // What draws large triangles tests them itself where they are masked; most scenes have no such thing.
  struct LargePipelines {
    gpu::Pipeline expand, tiles;
  };
  LargePipelines make_large(bool masks, gpu::Make when) const;
  const LargePipelines& large() const { return job_.scene->has_masked ? large_masked_ : large_; }

  gpu::Pipeline cull_, raster_, raster_narrow_, raster_mask_, farthest_depth_;
  LargePipelines large_, large_masked_;
  Job job_;
  uint32_t round_count_ = 1;
  std::array<VkDeviceAddress, 2> round_sets_{};  // RasterSet
  gpu::Buffer work_;                             // LargeWork and ViewWork of each round
  gpu::Buffer lists_, huge_, prepared_, tile_entries_;
  gpu::Buffer tile_lists_, tile_next_;  // where drawn tile by tile
  gpu::Buffer was_seen_, farthest_;
  bool nothing_seen_ = true;                                     // was_seen_ is new
  std::array<gpu::Buffer, gpu::kFramesInFlight> counts_;         // what the same slot's last frame counted
  std::array<uint32_t, gpu::kFramesInFlight> rounds_counted_{};  // by that frame; 0 = nothing yet
  Drawn drawn_;
  uint32_t clusters_in_view_ = 0, clusters_not_hidden_ = 0;  // of the last frames with one round and with two
  uint64_t frame_ = 0;
  uint32_t huge_capacity_ = 1u << 16;
};

}  // namespace fire3dv::passes
