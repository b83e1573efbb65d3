#include "renderer/passes/visibility/visibility_pass.h"

#include <algorithm>
#include <cstddef>
#include <string>

#include "renderer/passes/resources/shader_variant.h"
#include "shaders/shared/bindings.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

// LOD error budget of the camera.
constexpr float kLevelErrorPixels = 0.25f;
// Scene triangles per image pixel above which the coverage merge pays. Below, few pixels show several
// triangles of one surface, and the merge costs more than it saves in shading and rays.
constexpr double kMinTrianglesPerTracedPixel = 0.2, kMinTrianglesPerPixel = 0.5;

gpu::SetLayout create_image_set_layout(gpu::Device& device) {
  const VkDescriptorSetLayoutBinding bindings[] = {
      {FIRE3DV_BINDING_DISPLAY, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
      {FIRE3DV_BINDING_HDR, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}};
  return gpu::create_set_layout(device, bindings);
}

}  // namespace

gpu_types::RasterView raster_view(const View& view, VkExtent2D extent, CameraLevels levels) {
  gpu_types::RasterView raster{};
  raster.clip_from_world = view.clip_from_world;
  const glm::mat4 rows = glm::transpose(view.clip_from_world);
  const glm::vec4 planes[6] = {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1],
                               rows[3] - rows[1], rows[3] - rows[2], rows[2]};
  for (int i = 0; i < 6; ++i) {
    const float length = glm::length(glm::vec3(planes[i]));
    // A far plane at infinity has no direction; every point is inside.
    raster.planes_world[i] = length > 0 ? planes[i] / length : glm::vec4(0, 0, 0, 1);
  }
  raster.eye_world = view.orthographic ? glm::vec4(view.look_world, 0) : glm::vec4(view.eye_world, 1);
  raster.width = extent.width;
  raster.height = extent.height;
  if (levels != CameraLevels::finest) {
    const float pixels_per_m =
        0.5f * std::max(static_cast<float>(extent.width) * glm::length(glm::vec3(rows[0])),
                        static_cast<float>(extent.height) * glm::length(glm::vec3(rows[1])));
    raster.level_scale = pixels_per_m / kLevelErrorPixels;
    raster.surface_only = levels == CameraLevels::by_surface ? 1 : 0;
  }
  return raster;
}

VisibilityPass::VisibilityPass(gpu::Device& device, VkPipelineLayout layout,
                               VkDescriptorSetLayout scene_set_layout, uint32_t samples)
    : device_(device),
      samples_(samples),
      layout_(layout),
      raster_(device, layout, samples == 4 ? RasterKind::camera_4_samples : RasterKind::camera_1_sample),
      image_set_layout_(create_image_set_layout(device)) {
  shade_layout_ = gpu::create_pipeline_layout(device, std::array{scene_set_layout, image_set_layout_.get()});
  if (samples == 4) merge_coverage_[0] = gpu::create_compute_pipeline(device, layout, "merge_coverage.comp");
}

void VisibilityPass::set_targets(Targets& targets) {
  const VkExtent2D extent = targets.extent;
  const VkDeviceSize view_bytes = VkDeviceSize{8} * samples_ * extent.width * extent.height;
  if (!targets.visibility.buffer) {
    targets.visibility.buffer = gpu::create_buffer(device_, view_bytes * targets.views,
                                                   VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
    bind(targets);
  }
  targets_ = &targets;
  extent_ = extent;
  view_bytes_ = view_bytes;
}

void VisibilityPass::bind(Targets& targets) const {
  const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 2}};
  targets.shade_set = gpu::DescriptorSet(device_, image_set_layout_.get(), sizes);
  const VkDescriptorImageInfo images[] = {
      {VK_NULL_HANDLE, targets.display.view.get(), VK_IMAGE_LAYOUT_GENERAL},
      {VK_NULL_HANDLE, targets.hdr.view.get(), VK_IMAGE_LAYOUT_GENERAL}};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = targets.shade_set.get();
  write.dstBinding = FIRE3DV_BINDING_DISPLAY;
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  write.descriptorCount = can_write_samples() && targets.hdr ? 2 : 1;  // the second fills the next binding
  write.pImageInfo = images;
  vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
}

ClusterRaster::Job VisibilityPass::job_of(GpuScene& scene, settings::Cull cull, CameraLevels levels) const {
  ClusterRaster::Job job;
  job.scene = &scene;
  job.target = &targets_->visibility;
  job.target_bytes = targets_->visibility.buffer.size_bytes;
  job.view_count = targets_->views;
  job.extent = extent_;
  job.cull = cull;
  job.levels_of_detail = levels != CameraLevels::finest;
  return job;
}

void VisibilityPass::allocate(GpuScene& scene, settings::Cull cull, CameraLevels levels) {
  raster_.allocate(job_of(scene, cull, levels));
}

ClusterRaster& VisibilityPass::prepare(gpu::StagingRing& staging, GpuScene& scene,
                                       std::span<const View> views, std::span<const VkDeviceAddress> globals,
                                       bool common, settings::Cull cull, CameraLevels levels) {
  std::vector<gpu_types::RasterView> rasters;
  rasters.reserve(views.size());
  const VkExtent2D tiles = tiles_of(extent_);
  for (const View& view : views) {
    const auto first_sample = static_cast<uint32_t>(rasters.size() * view_bytes_ / 8);
    rasters.push_back(raster_view(view, extent_, levels));
    rasters.back().first_texel = first_sample;
    rasters.back().first_tile = static_cast<uint32_t>(rasters.size() - 1) * tiles.width * tiles.height;
  }
  ClusterRaster::Job job = job_of(scene, cull, levels);
  job.views = staging.write(std::span<const gpu_types::RasterView>(rasters)).address;
  job.globals = globals[0];
  if (common) job.globals_of_views.assign(globals.begin(), globals.end());
  raster_.begin(staging, job);
  return raster_;
}

bool VisibilityPass::merge_pays(const GpuScene& scene, bool traced) const {
  const auto pixels = static_cast<double>(extent_.width) * extent_.height;
  const double least = traced ? kMinTrianglesPerTracedPixel : kMinTrianglesPerPixel;
  return merge_coverage_[0] && static_cast<double>(scene.lod0_triangle_count) >= least * pixels;
}

void VisibilityPass::make_common_merge() {
  if (merge_coverage_[1]) return;
  ShaderVariant variant;
  variant.several_worlds = true;
  merge_coverage_[1] = gpu::create_compute_pipeline(device_, layout_, "merge_coverage.comp",
                                                    gpu::Compile::next, variant.constants());
}

void VisibilityPass::merge_coverage(gpu::Recorder& recorder, GpuScene& scene,
                                    std::span<const VkDeviceAddress> globals, bool traced,
                                    gpu::StagingRing* common) {
  if (!merge_pays(scene, traced)) return;
  std::vector<gpu_types::CoverageMergePush> pushes;
  for (uint32_t view = 0; view < globals.size(); ++view) pushes.push_back({globals[view], address_of(view)});
  if (common) make_common_merge();
  uint32_t layers = 1;
  if (common) {
    layers = static_cast<uint32_t>(pushes.size());
    pushes = {{common->write(std::span<const gpu_types::CoverageMergePush>(pushes)).address, 0}};
  }
  std::vector<Use> uses{Use(targets_->visibility.buffer, access::compute_write)};
  scene.add_reads(uses, access::compute_read);
  recorder.pass("coverage merge", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, merge_coverage_[common ? 1 : 0].get());
    const VkDescriptorSet set = scene.textures.set();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
    for (const gpu_types::CoverageMergePush& push : pushes) {
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      vkCmdDispatch(commands, (extent_.width + 7) / 8, (extent_.height + 7) / 8, layers);
    }
  });
}

gpu::Pipeline& VisibilityPass::shade_pipeline(const Shading& shading) {
  constexpr uint32_t kShadowModes = 3;  // shadow techniques without listing; higher indices are the variants
                                        // that test maps and list rays
  static_assert(FIRE3DV_SHADOWS_OFF < kShadowModes && FIRE3DV_SHADOWS_MASK < kShadowModes &&
                FIRE3DV_SHADOWS_MAP < kShadowModes);
  FIRE3DV_ASSERT(shading.shadows < kShadowModes);
  const uint32_t way = shading.tests_maps ? kShadowModes : shading.shadows;
  FIRE3DV_ASSERT((shading.material_flags & ~FIRE3DV_MATERIAL_OPTIONAL) == 0);
  constexpr uint32_t kWays = 256;
  gpu::Pipeline& pipeline =
      shade_[kWays * shading.material_flags + 16 * way + (shading.core_materials ? 8 : 0) +
             (shading.textures ? 4 : 0) + (shading.second_uv ? 2 : 0) + (shading.writes_samples ? 1 : 0) +
             (shading.ray_effects ? kWays / 4 : 0) + (shading.common ? kWays / 2 : 0)];
  if (!pipeline) {
    const std::string shader =
        std::string("shade") + (shading.core_materials ? "_core" : "") +
        (shading.ray_effects ? "_ray_effects" : "") + (shading.tests_maps ? "_test_maps" : "") +
        (shading.writes_samples ? "_unresolved" : "") + (samples_ == 4 ? "_4.comp" : "_1.comp");
    ShaderVariant variant;
    variant.shadows = shading.shadows;
    variant.textures = shading.textures;
    variant.second_uv = shading.second_uv;
    variant.material_flags = shading.material_flags;
    variant.several_worlds = shading.common;
    pipeline = gpu::create_compute_pipeline(device_, shade_layout_.get(), shader, gpu::Compile::next,
                                            variant.constants());
  }
  return pipeline;
}

void VisibilityPass::expect(const Shading& shading) {
  Shading listed = shading;
  listed.tests_maps = false;
  // The pipeline expected last is compiled first.
  if (shading.tests_maps && !shares_pipeline_with_listed(shading)) shade_pipeline(listed);
  shade_pipeline(shading);
}

VisibilityPass::Shading VisibilityPass::shading_of(const GpuScene& scene, uint32_t shadows,
                                                   bool writes_samples, bool ray_effects) {
  Shading shading{!scene.has_extensions && !ray_effects,
                  scene.has_textures,
                  scene.has_second_uv,
                  scene.material_flags,
                  writes_samples,
                  shadows};
  shading.ray_effects = ray_effects;
  return shading;
}

void VisibilityPass::expect_common(const GpuScene& scene, bool shades, uint32_t shadows, bool merges,
                                   bool traced) {
  if (merges && merge_pays(scene, traced)) make_common_merge();
  raster_.expect_common(scene.has_masked);
  if (!shades) return;
  Shading shading = shading_of(scene, shadows, false, false);
  shading.common = true;
  shade_pipeline(shading);  // the slowest: compiled first
}

gpu_types::ShadePush VisibilityPass::shade_push(const Shaded& shaded, size_t index,
                                                const settings::PostSettings& settings) const {
  const uint32_t view = shaded.first_view + static_cast<uint32_t>(index);
  gpu_types::ShadePush push{};
  push.globals = shaded.globals[index];
  push.visibility = address_of(view);
  push.exposure = exposure_of(shaded.views[index], settings);
  push.tone_map = tone_map_number(settings);
  push.first_row = view * extent_.height;
  if (shaded.ray_effects) push.ray_effects = targets_->ray_effects.address;
  return push;
}

void VisibilityPass::record_shade(gpu::Recorder& recorder, const char* name, Shades what,
                                  uint32_t shadow_technique, GpuScene& scene, ShadowPass& shadows,
                                  Targets& targets, std::span<gpu_types::ShadePush> views,
                                  const Samples& samples, gpu::StagingRing* common) {
  const bool ray_effects = views[0].ray_effects != 0;
  Shading shading = shading_of(scene, shadow_technique, samples.any, ray_effects);
  shading.common = common != nullptr;
  shading.tests_maps =
      what == Shades::all_and_lists || (what == Shades::listed && shares_pipeline_with_listed(shading));
  const VkPipeline pipeline = shade_pipeline(shading).get();
  const bool is_first = what != Shades::listed && views[0].first_row == 0;
  std::vector<Use> uses{Use(targets_->visibility.buffer, access::compute_read),
                        Use(targets.display, access::compute_write, is_first)};
  if (ray_effects) uses.emplace_back(targets.ray_effects, access::compute_read);
  if (samples.any) uses.emplace_back(targets.hdr, access::compute_write, is_first);
  scene.add_reads(uses, access::compute_read);
  if (what == Shades::all_and_lists) {
    shadows.add_map_reads(uses, access::compute_read);
    uses.emplace_back(shadows.mask(), access::compute_write);
    uses.emplace_back(shadows.lists(), access::compute_write);
    uses.emplace_back(shadows.entries(), access::compute_write);
    uses.emplace_back(shadows.listed_rays(), access::compute_write);
  } else {
    shadows.add_reads(uses, access::compute_read);
  }
  if (what == Shades::listed) {
    gpu::Access arguments = access::compute_read;
    arguments.stages |= access::indirect_read.stages;
    arguments.access |= access::indirect_read.access;
    uses.emplace_back(shadows.lists(), arguments);
    uses.emplace_back(shadows.entries(), access::compute_read);
  }
  for (gpu_types::ShadePush& push : views) {
    push.listed = what == Shades::listed ? 1 : 0;
    push.hdr_x = static_cast<uint32_t>(samples.unresolved.offset.x);
    push.hdr_y = static_cast<uint32_t>(samples.unresolved.offset.y);
    push.hdr_end_x = push.hdr_x + samples.unresolved.extent.width;
    push.hdr_end_y = push.hdr_y + samples.unresolved.extent.height;
    push.keeps_samples = samples.all ? 1 : 0;
  }
  gpu_types::ShadePush all{};
  uint32_t layers = 1;
  if (common) {
    layers = static_cast<uint32_t>(views.size());
    all.globals = common->write(std::span<const gpu_types::ShadePush>(views)).address;
    views = std::span(&all, 1);
  }
  recorder.pass(name, uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    const VkDescriptorSet sets[] = {scene.textures.set(), targets.shade_set.get()};
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, shade_layout_.get(), 0, 2, sets, 0,
                            nullptr);
    for (const gpu_types::ShadePush& push : views) {
      vkCmdPushConstants(commands, shade_layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      if (what == Shades::listed) {
        vkCmdDispatchIndirect(commands, shadows.lists().get(), offsetof(gpu_types::RayList, groups_x));
      } else {
        vkCmdDispatch(commands, (extent_.width + 7) / 8, (extent_.height + 7) / 8, layers);
      }
    }
  });
}

void VisibilityPass::shade(gpu::Recorder& recorder, GpuScene& scene, ShadowPass& shadows, Targets& targets,
                           const Shaded& shaded, const settings::PostSettings& settings,
                           const Samples& samples) {
  std::vector<gpu_types::ShadePush> views;
  for (size_t i = 0; i < shaded.views.size(); ++i) views.push_back(shade_push(shaded, i, settings));
  record_shade(recorder, "shade", Shades::all, shaded.shadows, scene, shadows, targets, views, samples,
               shaded.common);
}

void VisibilityPass::shade_and_trace(gpu::Recorder& recorder, GpuScene& scene, ShadowPass& shadows,
                                     Targets& targets, const Shaded& shaded,
                                     const settings::PostSettings& settings, const Samples& samples) {
  FIRE3DV_ASSERT(shaded.views.size() == 1);  // the ray list serves one view
  const VkDeviceAddress globals = shaded.globals[0];
  gpu_types::ShadePush push = shade_push(shaded, 0, settings);
  push.lists = shadows.lists().address;
  push.entries = shadows.entries().address;
  push.listed_rays = shadows.listed_rays().address;
  push.ray_list_capacity = shadows.ray_list_capacity();
  const std::span<gpu_types::ShadePush> view(&push, 1);
  record_shade(recorder, "shade", Shades::all_and_lists, shaded.shadows, scene, shadows, targets, view,
               samples);
  shadows.trace_listed(recorder, scene, {targets_->visibility.buffer, address_of(shaded.first_view)},
                       globals);
  record_shade(recorder, "shade again", Shades::listed, shaded.shadows, scene, shadows, targets, view,
               samples);
}

}  // namespace fire3dv::passes
