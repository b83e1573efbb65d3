#include "renderer/passes/shadows/shadow_pass.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <string>
#include <utility>

#include "renderer/passes/resources/shader_variant.h"
#include "renderer/passes/resources/sun_light.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

constexpr size_t kMaxPlanarCasters = 16;
constexpr uint32_t kSmallestSmallMap = 64, kLargestSmallMap = 512;  // texels along a side
// Workgroups of 64 threads that trace listed rays in a strided loop. A GPU gets more than fit at once. A CPU
// gets few of equal work, but within the loop limit (lanes.glsl).
constexpr uint32_t kListedRayGroups = 1024, kListedRayGroupsOnCpu = 64;
constexpr gpu_types::RayList kEmptyList{0, 1, 1, 0, 1, 1, 0};
constexpr gpu_types::RayList kEmptyLists[FIRE3DV_RAY_LISTS] = {kEmptyList, kEmptyList, kEmptyList};

gpu::Buffer table(gpu::Device& device, VkDeviceSize bytes) {
  return gpu::create_buffer(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

uint64_t max_buffer_bytes(const gpu::Device& device) {
  VkPhysicalDeviceMaintenance3Properties memory{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES};
  VkPhysicalDeviceMaintenance4Properties buffers{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES,
                                                 &memory};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &buffers, {}};
  vkGetPhysicalDeviceProperties2(device.physical(), &properties);
  return std::min(buffers.maxBufferSize, memory.maxMemoryAllocationSize);
}

}  // namespace

ShadowPass::ShadowPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples,
                       const ShadowTechnique& technique)
    : device_(device), layout_(layout), samples_(samples), technique_(technique) {
  if (technique.method != settings::ShadowMethod::off) {
    pipelines_.light_views[0] = gpu::create_compute_pipeline(device, layout, "light_views.comp");
    map_raster_.emplace(device, layout,
                        technique.hybrid ? RasterKind::lights : RasterKind::lights_center_only);
  }
  if (technique.method != settings::ShadowMethod::ray) return;
  // Shading mostly resolves shadows itself, and a CPU compiles this pipeline slowly.
  if (!technique.hybrid || !gpu::uses_cpu_variants(device)) make_classify();
  const std::string suffix = samples == 4 ? "_4" : "_1";
  const auto prepare = [&](Tracing& tracing, const std::string& variant) {
    if (technique.back_end == settings::RayBackEnd::query) {
      tracing.query = gpu::create_compute_pipeline(device, layout, "trace" + variant + ".comp");
    } else {
      tracing.pipeline =
          gpu::RayPipeline(device, layout, "trace" + variant + ".rgen", "trace.rmiss", "trace.rahit");
    }
  };
  prepare(pipelines_.trace_pixels, suffix);
  if (technique.hybrid) prepare(pipelines_.trace_listed, "_listed");
  lists_ = gpu::create_buffer(device, sizeof(kEmptyLists),
                              VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
                              gpu::Memory::device);
  for (gpu::Buffer& seen : list_readbacks_) {
    seen = gpu::create_buffer(device, sizeof(kEmptyLists), 0, gpu::Memory::readback);
    std::memset(seen.mapped, 0, sizeof(kEmptyLists));
  }
}

// Without rays, more texels than image pixels are invisible: 1024 for images of 640 x 480. With rays, a finer
// map saves rays, but a CPU rasterises its two maps about as slowly as it traces. On a CPU about one texel
// per pixel is fastest. Only ray-traced techniques use the outer map. Small maps, of which a batch has one
// per world and light, have about as many texels along a side as the image has pixels.
MapSizes ShadowPass::map_sizes() const {
  MapSizes sizes;
  sizes.maps_of_view = technique_.hybrid ? 2 : 1;
  const uint32_t pixels = targets_ ? std::max(targets_->extent.width, targets_->extent.height) : 0;
  if (technique_.map_side) {
    sizes.side = technique_.map_side;
  } else if (technique_.small_maps) {
    sizes.side = std::clamp(std::bit_ceil(pixels), kSmallestSmallMap, kLargestSmallMap);
  } else if (!targets_) {
    return sizes;
  } else if (technique_.method == settings::ShadowMethod::map) {
    sizes.side = std::clamp(std::bit_ceil(pixels + pixels / 2), sizes.side / 2, sizes.side);
  } else if (device_.report().type == gpu::DeviceType::software) {
    sizes.side = std::clamp(std::bit_floor(pixels), sizes.side / 8, sizes.side);
  }
  return sizes;
}

void ShadowPass::make_classify() {
  pipelines_.classify =
      gpu::create_compute_pipeline(device_, layout_, samples_ == 4 ? "classify_4.comp" : "classify_1.comp");
}

void ShadowPass::make_light_views_of_worlds() {
  if (pipelines_.light_views[1]) return;
  ShaderVariant variant;
  variant.several_worlds = true;
  pipelines_.light_views[1] = gpu::create_compute_pipeline(device_, layout_, "light_views.comp",
                                                           gpu::Compile::next, variant.constants());
}

void ShadowPass::expect_worlds(bool masks) {
  if (!map_raster_) return;
  map_raster_->expect_common(masks);
  make_light_views_of_worlds();
}

// Limits maps and masks to a share of device memory, since peers choose the number of lights.
ShadowLimits ShadowPass::shadow_limits() const {
  constexpr uint64_t kListShare = 8, kMapShare = 4, kMaskShare = 4;
  ShadowLimits limits;
  if (technique_.method == settings::ShadowMethod::off) {  // no maps and no mask
    limits.max_texels = UINT64_MAX;
    return limits;
  }
  const uint64_t memory = device_.memory_bytes();
  // Each view has a cluster list; see ClusterRaster.
  limits.max_views = memory / kListShare / state_.worlds /
                     (sizeof(uint32_t) * std::max<uint64_t>(state_.cluster_count, 1024));
  // One dispatch has the views of all worlds that a submission shows.
  const VkPhysicalDeviceLimits& device = device_.limits();
  limits.max_views =
      std::min<uint64_t>(limits.max_views, device.maxComputeWorkGroupCount[2] /
                                               std::min(state_.worlds, device.maxImageDimension2D));
  // All maps are in one buffer. Shaders index texels with 32 bits.
  const uint64_t map_bytes = std::min(memory / kMapShare, max_buffer_bytes(device_));
  const uint64_t all_texels = std::min<uint64_t>(UINT32_MAX, map_bytes / sizeof(uint32_t));
  if (state_.worlds > 1) limits.max_texels = std::max(limits.max_texels, all_texels) / state_.worlds;
  limits.max_fitted_texels = std::min(limits.max_fitted_texels, all_texels / state_.worlds);
  if (!targets_ || technique_.method != settings::ShadowMethod::ray) return limits;
  const uint64_t pixels = uint64_t{targets_->extent.width} * targets_->extent.height;
  const uint64_t word_bytes =
      std::max<uint64_t>(pixels, 1) * (sizeof(uint32_t) + sizeof(gpu_types::RayEntry));
  // Shaders index mask words with 32 bits.
  const uint64_t most =
      std::min(memory / kMaskShare / word_bytes, UINT32_MAX / std::max<uint64_t>(pixels, 1));
  limits.max_mask_words = static_cast<uint32_t>(std::clamp<uint64_t>(most, 1, UINT32_MAX));
  return limits;
}

ShadowPlan ShadowPass::make_plan(const std::vector<scene::PlacedLight>& lights,
                                 const ShadowLimits& limits) const {
  return plan_shadows(lights, samples_, technique_.method == settings::ShadowMethod::ray, map_sizes(),
                      limits);
}

void ShadowPass::set_lights_or_drop_shadows(const std::vector<scene::PlacedLight>& lights) {
  try {
    set_lights(lights, shadow_limits());
    return;
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
  }
  ShadowLimits none = shadow_limits();
  none.has_memory = false;
  set_lights(lights, none);
}

// Without memory for the maps, they shrink.
gpu::Buffer ShadowPass::create_maps(ShadowPlan& plan, const std::vector<scene::PlacedLight>& lights,
                                    ShadowLimits limits) const {
  for (;;) {
    try {
      return table(device_, state_.worlds * plan.texels * sizeof(uint32_t));
    } catch (const gpu::VulkanFailure& failure) {
      if (!gpu::is_out_of_memory(failure)) throw;
      limits.max_fitted_texels = plan.texels / 2;
      ShadowPlan smaller = make_plan(lights, limits);
      if (smaller.texels == plan.texels) throw;
      plan = std::move(smaller);
    }
  }
}

// Creates new buffers, since frames in flight read the old ones. Maps are reused if large enough: the next
// frame draws them behind a barrier.
void ShadowPass::set_lights(const std::vector<scene::PlacedLight>& lights, const ShadowLimits& limits) {
  ShadowPlan plan = make_plan(lights, limits);
  if (state_.light_shadows && plan == state_.plan) {
    state_.lights = lights;
    state_.light_count = static_cast<uint32_t>(lights.size());
    state_.max_mask_words = limits.max_mask_words;
    return;
  }
  const bool traces = technique_.method == settings::ShadowMethod::ray && !lights.empty();
  if (traces && !can_test_maps_while_shading(plan) && !pipelines_.classify) make_classify();
  const uint32_t view_count = state_.needs_maps ? static_cast<uint32_t>(plan.views.size()) : 0;
  gpu::Buffer maps;
  const VkDeviceSize map_bytes = state_.worlds * plan.texels * sizeof(uint32_t);
  if (view_count && state_.maps.buffer.size_bytes < map_bytes) maps = create_maps(plan, lights, limits);
  gpu::Buffer light_shadows = table(device_, plan.shadows.size() * sizeof(plan.shadows[0])),
              view_requests = table(device_, plan.views.size() * sizeof(plan.views[0]));
  ViewsLayout views = layout_views(view_count, state_.planar_caster_count);
  allocate_mask(plan);
  // No call below fails.
  use_views(std::move(views));
  if (maps) {
    state_.maps = {};
    state_.maps.buffer = std::move(maps);
  }
  state_.lights = lights;
  state_.light_count = static_cast<uint32_t>(lights.size());
  state_.view_count = view_count;
  state_.max_mask_words = limits.max_mask_words;
  state_.plan = std::move(plan);
  state_.light_shadows = std::move(light_shadows);
  state_.view_requests = std::move(view_requests);
  state_.lights_changed = true;
}

void ShadowPass::choose_planar_casters(const scene::Scene& scene, const GpuScene& gpu_scene) {
  state_.planar_caster_records.clear();
  const float scene_radius = 0.5f * glm::length(scene.bounds_max - scene.bounds_min);
  for (const PlanarCaster& planar : gpu_scene.planar_casters) {
    if (state_.planar_caster_records.size() == kMaxPlanarCasters) break;
    if (gpu_scene.is_hidden(planar.node)) continue;
    // With maps only, the maps must hold all casters. Only a ground plane that spans most of the scene
    // becomes a planar caster, since it would leave no resolution for the others.
    if (technique_.method == settings::ShadowMethod::map && planar.radius_m < 0.5f * scene_radius) break;
    state_.planar_caster_records.push_back({planar.plane_node, planar.part});
  }
  state_.planar_caster_count =
      state_.needs_maps ? static_cast<uint32_t>(state_.planar_caster_records.size()) : 0;
  state_.planar_casters =
      table(device_, state_.planar_caster_records.size() * sizeof(state_.planar_caster_records[0]));
  state_.planar_casters_changed = true;
  use_views(layout_views(state_.view_count, state_.planar_caster_count));
}

ShadowPass::ViewsLayout ShadowPass::layout_views(uint32_t view_count, uint32_t planar_caster_count) const {
  const auto padded = [](VkDeviceSize size) { return (size + 255) / 256 * 256; };
  ViewsLayout layout;
  layout.planar_casters_offset = padded(state_.worlds * view_count * sizeof(gpu_types::RasterView));
  layout.planar_casters_bytes = padded(planar_caster_count * sizeof(gpu_types::PlanarCasterPlane));
  layout.backface_casters_offset = layout.planar_casters_offset + state_.worlds * layout.planar_casters_bytes;
  layout.backface_casters_bytes = padded(state_.part_count * sizeof(uint32_t));
  const VkDeviceSize bytes =
      layout.backface_casters_offset + state_.worlds * layout.backface_casters_bytes + 256;
  if (state_.needs_maps && (!state_.views || state_.views.size_bytes != bytes))
    layout.buffer = table(device_, bytes);
  return layout;
}

void ShadowPass::use_views(ViewsLayout&& layout) {
  if (layout.buffer) state_.views = std::move(layout.buffer);
  state_.planar_casters_offset = layout.planar_casters_offset;
  state_.planar_casters_bytes = layout.planar_casters_bytes;
  state_.backface_casters_offset = layout.backface_casters_offset;
  state_.backface_casters_bytes = layout.backface_casters_bytes;
}

void ShadowPass::set_scene(const scene::Scene& scene, const GpuScene& gpu_scene) {
  State before = std::exchange(state_, State());
  try {
    // Forward-only draws have no mask; without ray queries they need maps.
    state_.needs_maps = technique_.method == settings::ShadowMethod::map || technique_.hybrid ||
                        (technique_.back_end == settings::RayBackEnd::pipeline && gpu_scene.has_forward_only);
    state_.worlds = gpu_scene.world_count;
    state_.part_count = gpu_scene.part_count;
    state_.cluster_count = gpu_scene.cluster_instance_count;
    choose_planar_casters(scene, gpu_scene);
    set_lights(drawn_lights(scene, nullptr, added_lights(gpu_scene)),
               shadow_limits());  // last: the mask belongs to the targets, not to the state
  } catch (const gpu::VulkanFailure&) {
    state_ = std::move(before);
    throw;
  }
}

void ShadowPass::upload_changes(gpu::Recorder& recorder, gpu::StagingRing& staging) {
  if (!state_.lights_changed && !state_.planar_casters_changed) return;
  // The last choice before the frame wins.
  gpu::Patches patches;
  if (std::exchange(state_.lights_changed, false)) {
    patches.write(state_.light_shadows, 0, std::span<const gpu_types::LightShadow>(state_.plan.shadows));
    patches.write(state_.view_requests, 0, std::span<const gpu_types::LightViewRequest>(state_.plan.views));
  }
  if (std::exchange(state_.planar_casters_changed, false))
    patches.write(state_.planar_casters, 0,
                  std::span<const gpu_types::PlanarCasterRecord>(state_.planar_caster_records));
  patches.record(recorder, staging);
}

void ShadowPass::set_targets(Targets& targets) {
  targets_ = &targets;
  // The image size limits the mask words; most plans need far fewer.
  const auto words = [&](uint32_t max) { return std::min(max, state_.plan.mask_words_wanted); };
  const bool other_plan =
      state_.light_shadows && (map_sizes() != state_.plan.sizes ||
                               words(shadow_limits().max_mask_words) != words(state_.max_mask_words));
  if (other_plan) set_lights(std::vector(state_.lights), shadow_limits());
  allocate_mask(state_.plan);
}

void ShadowPass::allocate_mask(const ShadowPlan& plan) {
  if (technique_.method != settings::ShadowMethod::ray || !targets_) return;
  if (technique_.hybrid && plan.all_hard() && plan.mask_words == 1 && !targets_->listed_rays)
    targets_->listed_rays = table(device_, ray_list_capacity() * sizeof(gpu_types::ListedRay));
  const VkDeviceSize words = VkDeviceSize{targets_->extent.width} * targets_->extent.height * plan.mask_words;
  if (targets_->shadow_mask && targets_->shadow_mask.size_bytes == words * sizeof(uint32_t)) return;
  gpu::Buffer mask = table(device_, words * sizeof(uint32_t));
  targets_->shadow_entries = table(device_, words * sizeof(gpu_types::RayEntry));
  targets_->shadow_mask = std::move(mask);
}

void ShadowPass::MapSets::set_cameras(std::span<const uint32_t> set_of,
                                      std::span<const VkDeviceAddress> globals) {
  first.assign(count + size_t{1}, 0);
  for (const uint32_t set : set_of) ++first[set + size_t{1}];
  for (uint32_t set = 0; set < count; ++set) first[set + size_t{1}] += first[set];
  std::vector<uint32_t> next = first;
  cameras.resize(globals.size());
  for (size_t view = 0; view < globals.size(); ++view) cameras[next[set_of[view]]++] = globals[view];
}

void ShadowPass::write_globals(gpu_types::Globals& globals) const {
  globals.light_shadows = state_.light_shadows.address;
  globals.shadow_maps = state_.maps.buffer.address;
  globals.map_generation = state_.maps.generation();
  globals.shadow_mask = targets_->shadow_mask.address;
  globals.planar_caster_count = state_.planar_caster_count;
  globals.mask_words = state_.plan.mask_words;
}

void ShadowPass::write_map_globals(gpu_types::Globals& globals, uint32_t map_set) const {
  const VkDeviceAddress views = state_.views.address;
  globals.light_views = views + VkDeviceSize{map_set} * state_.view_count * sizeof(gpu_types::RasterView);
  globals.planar_casters = views + state_.planar_casters_offset + map_set * state_.planar_casters_bytes;
  globals.backface_casters = views + state_.backface_casters_offset + map_set * state_.backface_casters_bytes;
}

uint32_t ShadowPass::shader_mode(bool masked) const {
  switch (technique_.method) {
    case settings::ShadowMethod::off:
      return FIRE3DV_SHADOWS_OFF;
    case settings::ShadowMethod::map:
      return FIRE3DV_SHADOWS_MAP;
    default:
      return masked ? FIRE3DV_SHADOWS_MASK : FIRE3DV_SHADOWS_INLINE;
  }
}

ClusterRaster* ShadowPass::prepare_maps(gpu::StagingRing& staging, GpuScene& scene, const MapSets& sets,
                                        settings::Cull cull, bool levels_of_detail) {
  if (state_.view_count == 0) return nullptr;
  ClusterRaster::Job job;
  job.scene = &scene;
  job.views_written = &state_.views;
  job.target = &state_.maps;
  job.target_bytes = map_bytes(sets.count);
  job.views = state_.views.address;
  job.globals = sets.cameras[0];
  job.view_count = sets.count * state_.view_count;
  if (sets.count > 1) {
    job.globals_of_views.reserve(job.view_count);
    for (uint32_t set = 0; set < sets.count; ++set)
      job.globals_of_views.insert(job.globals_of_views.end(), state_.view_count,
                                  sets.cameras[sets.first[set]]);
  }
  for (const gpu_types::LightViewRequest& view : state_.plan.views)
    job.extent = {std::max(job.extent.width, view.size), std::max(job.extent.height, view.size)};
  job.cull = cull;
  job.levels_of_detail = levels_of_detail;
  map_raster_->begin(staging, job);
  return &*map_raster_;
}

void ShadowPass::fit_map_views(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
                               const MapSets& sets, bool levels_of_detail, ClusterRaster::Clear clear) {
  std::vector<Use> uses = std::move(clear.uses);
  uses.emplace_back(state_.views, access::compute_write);
  scene.add_reads(uses, access::compute_read);
  const VkDeviceAddress cameras =
      staging.write(std::span<const VkDeviceAddress>(sets.cameras)).address;  // of all sets
  std::vector<gpu_types::LightViewsPush> worlds(sets.count);
  for (size_t set = 0; set < sets.count; ++set) {
    const uint32_t first = sets.first[set];
    gpu_types::LightViewsPush& push = worlds[set];
    push.globals = sets.cameras[first];
    push.cameras = cameras + first * sizeof(VkDeviceAddress);
    push.wanted = state_.view_requests.address;
    push.views = state_.views.address + set * state_.view_count * sizeof(gpu_types::RasterView);
    push.planar_casters = state_.planar_casters.address;
    push.view_count = state_.view_count;
    push.levels_of_detail = levels_of_detail ? 1 : 0;
    push.camera_count = sets.first[set + 1] - first;
    push.first_texel = static_cast<uint32_t>(set * state_.plan.texels);
  }
  const bool common = worlds.size() > 1;
  gpu_types::LightViewsPush push = worlds[0];
  if (common) {
    make_light_views_of_worlds();
    push = {};
    push.globals = staging.write(std::span<const gpu_types::LightViewsPush>(worlds)).address;
  }
  recorder.pass("light views", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.light_views[common ? 1 : 0].get());
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    constexpr uint32_t kThreads = FIRE3DV_LIGHT_VIEW_THREADS;
    vkCmdDispatch(commands, state_.view_count + (scene.part_count + kThreads - 1) / kThreads,
                  static_cast<uint32_t>(worlds.size()), 1);
    clear.commands(commands);
  });
}

bool ShadowPass::can_test_maps_while_shading(const ShadowPlan& plan) const {
  return technique_.hybrid && plan.all_hard() && plan.mask_words == 1;
}

bool ShadowPass::tests_maps_while_shading() const {
  return traces() && can_test_maps_while_shading(state_.plan);
}

gpu_types::ShadowPush ShadowPass::push(const Visibility& visibility, VkDeviceAddress globals) const {
  return {globals,
          visibility.address,
          lists_.address,
          targets_->shadow_entries.address,
          targets_->listed_rays.address,
          ray_list_capacity(),
          technique_.hybrid ? 1u : 0u};
}

void ShadowPass::bind(VkCommandBuffer commands, VkPipelineBindPoint point, VkPipeline pipeline,
                      GpuScene& scene, const gpu_types::ShadowPush& push) const {
  vkCmdBindPipeline(commands, point, pipeline);
  const VkDescriptorSet set = scene.textures.set();
  vkCmdBindDescriptorSets(commands, point, layout_, 0, 1, &set, 0, nullptr);
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
}

void ShadowPass::record(gpu::Recorder& recorder, GpuScene& scene, const Visibility& visibility,
                        VkDeviceAddress globals) {
  if (!traces()) return;
  if (!pipelines_.classify)
    make_classify();  // for the forward path, in configurations where shading usually resolves
                      // shadows
  std::vector<Use> uses{Use(visibility.buffer, access::compute_read), Use(lists_, access::compute_write),
                        Use(entries(), access::compute_write), Use(mask(), access::compute_write)};
  scene.add_reads(uses, access::compute_read);
  add_map_reads(uses, access::compute_read);
  recorder.pass("classify", uses, [&](VkCommandBuffer commands) {
    bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.classify.get(), scene,
         push(visibility, globals));
    vkCmdDispatch(commands, (targets_->extent.width + 7) / 8, (targets_->extent.height + 7) / 8,
                  state_.plan.mask_words);
  });
  trace(recorder, scene, visibility, globals, false);
}

void ShadowPass::clear_ray_lists(gpu::Recorder& recorder) {
  if (!traces()) return;
  recorder.transition({Use(lists_, access::transfer_write)});
  vkCmdUpdateBuffer(recorder.commands(), lists_.get(), 0, sizeof(kEmptyLists), kEmptyLists);
}

uint32_t ShadowPass::ray_list_capacity() const {
  if (technique_.max_listed_rays) return technique_.max_listed_rays;
  return std::max(1u, targets_->extent.width * targets_->extent.height / 2);
}

void ShadowPass::trace_listed(gpu::Recorder& recorder, GpuScene& scene, const Visibility& visibility,
                              VkDeviceAddress globals) {
  trace(recorder, scene, visibility, globals, true);
}

void ShadowPass::record_trace(VkCommandBuffer commands, const Tracing& tracing, uint32_t list,
                              GpuScene& scene, const gpu_types::ShadowPush& push) const {
  const VkDeviceSize offset = list * sizeof(gpu_types::RayList);
  if (technique_.back_end == settings::RayBackEnd::query) {
    bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, tracing.query.get(), scene, push);
    if (list == FIRE3DV_LIST_RAYS) {
      const bool cpu = device_.report().type == gpu::DeviceType::software;
      return vkCmdDispatch(commands, cpu ? kListedRayGroupsOnCpu : kListedRayGroups, 1, 1);
    }
    vkCmdDispatchIndirect(commands, lists_.get(), offset + offsetof(gpu_types::RayList, groups_x));
  } else {
    bind(commands, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, tracing.pipeline.get(), scene, push);
    tracing.pipeline.trace(commands, lists_.address + offset);
  }
}

void ShadowPass::trace(gpu::Recorder& recorder, GpuScene& scene, const Visibility& visibility,
                       VkDeviceAddress globals, bool listed) {
  const bool query = technique_.back_end == settings::RayBackEnd::query;
  const gpu::Access read = query ? access::compute_read : access::ray_read;
  const gpu::Access write = query ? access::compute_write : access::ray_write;
  gpu::Access arguments = read;  // the list holds dispatch arguments and input
  arguments.stages |= access::indirect_read.stages;
  arguments.access |= access::indirect_read.access;
  std::vector<Use> uses{Use(visibility.buffer, read), Use(lists_, arguments), Use(entries(), read),
                        Use(mask(), write),
                        Use(scene.top_level.storage(), query ? access::compute_trace : access::ray_trace)};
  scene.add_reads(uses, read);
  if (listed) uses.emplace_back(targets_->listed_rays, read);
  recorder.pass("trace", uses, [&](VkCommandBuffer commands) {
    const gpu_types::ShadowPush what = push(visibility, globals);
    if (listed) record_trace(commands, pipelines_.trace_listed, FIRE3DV_LIST_RAYS, scene, what);
    record_trace(commands, pipelines_.trace_pixels, listed ? FIRE3DV_LIST_OVERFLOW : FIRE3DV_LIST_PIXELS,
                 scene, what);
  });
  gpu::Buffer& seen = list_readbacks_[frame_++ % gpu::kFramesInFlight];
  gpu_types::RayList last[FIRE3DV_RAY_LISTS];
  std::memcpy(last, seen.mapped, sizeof(last));
  rays_traced_ = uint64_t{last[FIRE3DV_LIST_PIXELS].rays} + last[FIRE3DV_LIST_RAYS].width;
  recorder.copy_at_end(lists_, seen, {{0, 0, sizeof(last)}});
}

void ShadowPass::add_reads(std::vector<Use>& uses, const gpu::Access& access) {
  if (traces()) uses.emplace_back(mask(), access);
  add_map_reads(uses, access);
}

void ShadowPass::add_map_reads(std::vector<Use>& uses, const gpu::Access& access) {
  if (state_.needs_maps) uses.emplace_back(state_.views, access);
  if (state_.view_count) uses.emplace_back(state_.maps.buffer, access);
}

}  // namespace fire3dv::passes
