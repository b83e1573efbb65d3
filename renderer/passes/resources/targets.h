// Render targets: the images, buffers and descriptor sets of one image size, and raster targets with depth
// generations.
#pragma once

#include <optional>
#include <vector>

#include "renderer/gpu/device/resources.h"
#include "renderer/gpu/pipelines/descriptors.h"
#include "shaders/shared/raster_types.h"

namespace fire3dv::passes {

// Raster target with depth generations: it is cleared for every fourth drawing only. The two top bits of a
// depth, unused by depths in [0, 2), hold the generation. Newer generations win over older ones, and readers
// ignore depths of older generations.
struct ClusterTarget {
  gpu::Buffer buffer;

  // Starts a generation. Call it before submitted commands draw into the first `bytes` of the buffer.
  void begin(VkDeviceSize bytes) {
    const bool start_over = bytes > clean_bytes_ || generation_ == FIRE3DV_LAST_GENERATION;
    generation_ = start_over ? 0 : generation_ + FIRE3DV_GENERATION;
    if (start_over) clean_bytes_ = bytes;
  }
  // The same for a target without generation bits; it is always cleared.
  void begin_empty(VkDeviceSize bytes) {
    generation_ = 0;
    clean_bytes_ = bytes;
  }
  // Invalidates the content; the next drawing clears it.
  void invalidate() { clean_bytes_ = 0; }
  // True if as many bytes as begin() got must be cleared before the drawing.
  bool needs_clear() const { return generation_ == 0; }
  uint32_t generation() const { return generation_; }  // as in the top bits of its depths

 private:
  uint32_t generation_ = FIRE3DV_LAST_GENERATION;
  VkDeviceSize clean_bytes_ = 0;  // cleared range: it has no depths of later generations
};

// Images of the bloom chain, half floats. Its first level is half as wide and high as the image.
struct BloomImages {
  gpu::Image light;  // exposed, of the image's size
  std::vector<gpu::Image> levels;
  std::vector<gpu::DescriptorSet> down_sets, up_sets;  // of BloomPass, by written level
  gpu::DescriptorSet light_set;                        // of BloomPass
  gpu::DescriptorSet tone_map_set;                     // of PostPass or PathPass
};

// With several views, `display` and `smoothed` stack them vertically, and `hdr` and `depth` do not exist.
struct Targets {
  Targets(gpu::Device& device, VkExtent2D extent, uint32_t views, VkSampleCountFlagBits samples);

  VkExtent2D extent{};  // of a view
  uint32_t views = 1;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  gpu::Image hdr;                    // linear HDR colour, multisampled
  gpu::Image depth;                  // reversed, multisampled
  gpu::Image display;                // tone-mapped, resolved, sRGB-encoded RGBA8
  gpu::Image smoothed;               // display after FXAA; of several views: created by bind_layers()
  gpu::Image layers;                 // of several views: display as an array, the source of FXAA
  std::optional<BloomImages> bloom;  // of images with bloom

  // Buffers of VisibilityPass and ShadowPass, where these exist.
  ClusterTarget visibility;    // uint64_t[view][pixel][sample]
  gpu::Buffer shadow_mask;     // uint32_t[pixel][word]
  gpu::Buffer shadow_entries;  // gpu_types::RayEntry[pixel][word]
  gpu::Buffer listed_rays;     // gpu_types::ListedRay[]
  gpu::Buffer ray_effects;     // gpu_types::RayEffectRecord[pixel][sample]; null: no image had them
  // Each set belongs to the pass that writes it.
  gpu::DescriptorSet shade_set, tone_map_set, fxaa_set, stale_overlay_set, overlay_set, path_set,
      light_meter_set, depth_of_field_set, camera_light_set, camera_light_bloom_set, sensor_set;
  VkImageView stale_overlay_view = VK_NULL_HANDLE, overlay_view = VK_NULL_HANDLE;  // of the last two
};

// Approximate device memory of the targets.
VkDeviceSize bytes_of(const Targets& targets);

}  // namespace fire3dv::passes
