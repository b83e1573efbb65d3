#include "renderer/passes/shadows/shadow_pass.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <string>
#include <utility>

#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

constexpr size_t kMostSheets = 16;
// Workgroups of 64 threads that trace listed rays in a strided loop. A GPU gets more than fit at once. A CPU
// gets few of equal work, but within the loop limit (lanes.glsl).
constexpr uint32_t kGroupsOfFound = 1024, kGroupsOfFoundOnCpu = 64;
constexpr gpu_types::RayList kEmptyList{0, 1, 1, 0, 1, 1, 0};
constexpr gpu_types::RayList kEmptyLists[FIRE3DV_RAY_LISTS] = {kEmptyList, kEmptyList, kEmptyList};

gpu::Buffer table(gpu::Device& device, VkDeviceSize bytes) {
  return gpu::create_buffer(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

}  // namespace

ShadowTechnique choose_shadow_way(const gpu::Device& device, const ShadowSettings& settings, bool compute) {
  ShadowTechnique way;
  way.map_side = settings.map_side;
  way.most_found = settings.most_found;
  if (settings.method == ShadowMethod::off) return way;
  const gpu::DeviceReport& report = device.report();
  const bool can_trace = report.ray_query || report.ray_tracing_pipeline;
  if (settings.method == ShadowMethod::map || !can_trace) {
    way.method = ShadowMethod::map;
    return way;
  }
  way.method = ShadowMethod::ray;
  const bool pipeline =
      report.ray_tracing_pipeline && (settings.back_end == RayBackEnd::pipeline || !report.ray_query);
  way.hybrid = settings.hybrid && (compute || pipeline);
  way.back_end = pipeline ? RayBackEnd::pipeline : RayBackEnd::query;
  return way;
}

const char* describe(const ShadowTechnique& way) {
  switch (way.method) {
    case ShadowMethod::off:
    case ShadowMethod::automatic:
      return "nothing";
    case ShadowMethod::map:
      return "shadow maps";
    case ShadowMethod::ray:
      break;
  }
  if (way.back_end == RayBackEnd::query) return way.hybrid ? "shadow maps and ray query" : "ray query";
  return way.hybrid ? "shadow maps and a ray-tracing pipeline" : "a ray-tracing pipeline";
}

ShadowPass::ShadowPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples,
                       const ShadowTechnique& way)
    : device_(device), layout_(layout), samples_(samples), way_(way) {
  if (way.method != ShadowMethod::off) {
    light_views_ = gpu::create_compute_pipeline(device, layout, "light_views.comp");
    map_raster_.emplace(device, layout, way.hybrid ? RasterKind::lights : RasterKind::lights_middles);
  }
  if (way.method != ShadowMethod::ray) return;
  // Shading mostly resolves shadows itself, and a CPU compiles this pipeline slowly.
  if (!way.hybrid || !gpu::takes_cpu_variants(device)) make_classify();
  const std::string suffix = samples == 4 ? "_4" : "_1";
  const auto prepare = [&](Tracing& tracing, const std::string& variant) {
    if (way.back_end == RayBackEnd::query) {
      tracing.query = gpu::create_compute_pipeline(device, layout, "trace" + variant + ".comp");
    } else {
      tracing.pipeline = gpu::RayPipeline(device, layout, "trace" + variant + ".rgen", "trace.rmiss",
                                          "trace.rahit");
    }
  };
  prepare(trace_pixels_, suffix);
  if (way.hybrid) prepare(trace_found_, "_found");
  lists_ = gpu::create_buffer(device, sizeof(kEmptyLists),
                              VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
                              gpu::Memory::device);
  for (gpu::Buffer& seen : lists_seen_) {
    seen = gpu::create_buffer(device, sizeof(kEmptyLists), 0, gpu::Memory::readback);
    std::memset(seen.mapped, 0, sizeof(kEmptyLists));
  }
}

// Without rays, more texels than image pixels are invisible: 1024 for images of 640 x 480. With rays, a finer
// map saves rays, but a CPU rasterises its two maps about as slowly as it traces. On a CPU about one texel
// per pixel is fastest. Only ray-traced techniques use the outer map.
MapSizes ShadowPass::map_sizes() const {
  MapSizes sizes;
  sizes.maps_of_view = way_.hybrid ? 2 : 1;
  if (way_.map_side) sizes.side = way_.map_side;
  if (way_.map_side || !targets_) return sizes;
  const uint32_t pixels = std::max(targets_->extent.width, targets_->extent.height);
  if (way_.method == ShadowMethod::map) {
    sizes.side = std::clamp(std::bit_ceil(pixels + pixels / 2), sizes.side / 2, sizes.side);
  } else if (device_.report().type == gpu::DeviceType::software) {
    sizes.side = std::clamp(std::bit_floor(pixels), sizes.side / 8, sizes.side);
  }
  return sizes;
}

void ShadowPass::make_classify() {
  classify_ =
      gpu::create_compute_pipeline(device_, layout_, samples_ == 4 ? "classify_4.comp" : "classify_1.comp");
}

// Limits maps and masks to a share of device memory, since peers choose the number of lights.
ShadowRoom ShadowPass::shadow_room() const {
  constexpr uint64_t kListShare = 8, kMaskShare = 4;
  ShadowRoom room;
  const uint64_t memory = device_.memory_bytes();
  // Each view has a cluster list; see ClusterRaster.
  room.max_views = memory / kListShare / (sizeof(uint32_t) * std::max<uint64_t>(state_.cluster_count, 1024));
  if (!targets_ || way_.method != ShadowMethod::ray) return room;
  const uint64_t pixels = uint64_t{targets_->extent.width} * targets_->extent.height;
  const uint64_t word_bytes =
      std::max<uint64_t>(pixels, 1) * (sizeof(uint32_t) + sizeof(gpu_types::RayEntry));
  // Shaders index mask words with 32 bits.
  const uint64_t most =
      std::min(memory / kMaskShare / word_bytes, UINT32_MAX / std::max<uint64_t>(pixels, 1));
  room.max_mask_words = static_cast<uint32_t>(std::clamp<uint64_t>(most, 1, UINT32_MAX));
  return room;
}

void ShadowPass::set_lights_or_drop_shadows(const std::vector<scene::PlacedLight>& lights) {
  try {
    set_lights(lights, shadow_room());
    return;
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
  }
  ShadowRoom none = shadow_room();
  none.has_room = false;
  set_lights(lights, none);
}

// Creates new buffers, since frames in flight read the old ones. Maps are reused if large enough: the next
// frame draws them behind a barrier.
void ShadowPass::set_lights(const std::vector<scene::PlacedLight>& lights, const ShadowRoom& room) {
  ShadowPlan plan = plan_shadows(lights, samples_, way_.method == ShadowMethod::ray, map_sizes(), room);
  if (state_.light_shadows && plan == state_.plan) {
    state_.lights = lights;
    state_.light_count = static_cast<uint32_t>(lights.size());
    state_.max_mask_words = room.max_mask_words;
    return;
  }
  const bool traces = way_.method == ShadowMethod::ray && !lights.empty();
  if (traces && !finds_while_shading(plan) && !classify_) make_classify();
  const uint32_t view_count = state_.needs_maps ? static_cast<uint32_t>(plan.views.size()) : 0;
  gpu::Buffer light_shadows = table(device_, plan.shadows.size() * sizeof(plan.shadows[0])),
              wanted_views = table(device_, plan.views.size() * sizeof(plan.views[0])), maps;
  const VkDeviceSize map_bytes = plan.texels * sizeof(uint32_t);
  if (view_count && state_.maps.buffer.size_bytes < map_bytes) maps = table(device_, map_bytes);
  ViewsPlace views = place_views(view_count, state_.sheet_count);
  make_room_for_mask(plan);
  // No call below fails.
  use_views(std::move(views));
  if (maps) {
    state_.maps = {};
    state_.maps.buffer = std::move(maps);
  }
  state_.lights = lights;
  state_.light_count = static_cast<uint32_t>(lights.size());
  state_.view_count = view_count;
  state_.max_mask_words = room.max_mask_words;
  state_.plan = std::move(plan);
  state_.light_shadows = std::move(light_shadows);
  state_.wanted_views = std::move(wanted_views);
  state_.lights_chosen = true;
}

void ShadowPass::choose_sheets(const scene::Scene& scene, const GpuScene& gpu_scene) {
  state_.sheet_records.clear();
  const float scene_radius = 0.5f * glm::length(scene.bounds_max - scene.bounds_min);
  for (const PlanarPart& planar : gpu_scene.planar_parts) {
    if (state_.sheet_records.size() == kMostSheets) break;
    if (gpu_scene.is_hidden(planar.node)) continue;
    // With maps only, the maps must hold all casters. Only a ground plane that spans most of the scene
    // becomes a planar occluder, since it would leave no resolution for the others.
    if (way_.method == ShadowMethod::map && planar.radius_m < 0.5f * scene_radius) break;
    state_.sheet_records.push_back({planar.plane_node, planar.part});
  }
  state_.sheet_count = state_.needs_maps ? static_cast<uint32_t>(state_.sheet_records.size()) : 0;
  state_.sheets = table(device_, state_.sheet_records.size() * sizeof(state_.sheet_records[0]));
  state_.sheets_chosen = true;
  use_views(place_views(state_.view_count, state_.sheet_count));
}

ShadowPass::ViewsPlace ShadowPass::place_views(uint32_t view_count, uint32_t sheet_count) const {
  const auto padded = [](VkDeviceSize size) { return (size + 255) / 256 * 256; };
  ViewsPlace place;
  place.sheets_offset = padded(view_count * sizeof(gpu_types::RasterView));
  place.far_sides_offset = place.sheets_offset + padded(sheet_count * sizeof(gpu_types::SheetPlace));
  const VkDeviceSize bytes = place.far_sides_offset + padded(state_.part_count * sizeof(uint32_t)) + 256;
  if (state_.needs_maps && (!state_.views || state_.views.size_bytes != bytes))
    place.buffer = table(device_, bytes);
  return place;
}

void ShadowPass::use_views(ViewsPlace&& place) {
  if (place.buffer) state_.views = std::move(place.buffer);
  state_.sheets_offset = place.sheets_offset;
  state_.far_sides_offset = place.far_sides_offset;
}

void ShadowPass::set_scene(const scene::Scene& scene, const GpuScene& gpu_scene) {
  State before = std::exchange(state_, State());
  try {
    // Forward-only draws have no mask; without ray queries they need maps.
    state_.needs_maps = way_.method == ShadowMethod::map || way_.hybrid ||
                        (way_.back_end == RayBackEnd::pipeline && gpu_scene.has_forward_only);
    state_.part_count = gpu_scene.part_count;
    state_.cluster_count = gpu_scene.cluster_instance_count;
    choose_sheets(scene, gpu_scene);
    set_lights(scene::lights_of(scene, nullptr),
               shadow_room());  // last: the mask belongs to the targets, not to the state
  } catch (const gpu::VulkanFailure&) {
    state_ = std::move(before);
    throw;
  }
}

void ShadowPass::upload_choices(gpu::Recorder& recorder, gpu::StagingRing& belt) {
  if (!state_.lights_chosen && !state_.sheets_chosen) return;
  // The last choice before the frame wins.
  Patches choices;
  if (std::exchange(state_.lights_chosen, false)) {
    choices.write(state_.light_shadows, 0, std::span<const gpu_types::LightShadow>(state_.plan.shadows));
    choices.write(state_.wanted_views, 0, std::span<const gpu_types::LightViewWanted>(state_.plan.views));
  }
  if (std::exchange(state_.sheets_chosen, false))
    choices.write(state_.sheets, 0, std::span<const gpu_types::SheetRecord>(state_.sheet_records));
  choices.record(recorder, belt);
}

void ShadowPass::set_targets(Targets& targets) {
  targets_ = &targets;
  // The image size limits the mask words; most plans need far fewer.
  const auto words = [&](uint32_t max) { return std::min(max, state_.plan.mask_words_wanted); };
  const bool other_plan =
      state_.light_shadows && (map_sizes() != state_.plan.sizes ||
                               words(shadow_room().max_mask_words) != words(state_.max_mask_words));
  if (other_plan) set_lights(std::vector(state_.lights), shadow_room());
  make_room_for_mask(state_.plan);
}

void ShadowPass::make_room_for_mask(const ShadowPlan& plan) {
  if (way_.method != ShadowMethod::ray || !targets_) return;
  if (way_.hybrid && plan.all_hard() && plan.mask_words == 1 && !targets_->found_rays)
    targets_->found_rays = table(device_, found_room() * sizeof(gpu_types::FoundRay));
  const VkDeviceSize words = VkDeviceSize{targets_->extent.width} * targets_->extent.height * plan.mask_words;
  if (targets_->shadow_mask && targets_->shadow_mask.size_bytes == words * sizeof(uint32_t)) return;
  gpu::Buffer mask = table(device_, words * sizeof(uint32_t));
  targets_->shadow_entries = table(device_, words * sizeof(gpu_types::RayEntry));
  targets_->shadow_mask = std::move(mask);
}

void ShadowPass::describe_to(gpu_types::Globals& globals) const {
  globals.light_shadows = state_.light_shadows.address;
  globals.light_views = state_.views.address;
  globals.shadow_maps = state_.maps.buffer.address;
  globals.map_generation = state_.maps.generation();
  globals.shadow_mask = targets_->shadow_mask.address;
  globals.sheets = state_.views.address + state_.sheets_offset;
  globals.far_sides = state_.views.address + state_.far_sides_offset;
  globals.sheet_count = state_.sheet_count;
  globals.mask_words = state_.plan.mask_words;
}

uint32_t ShadowPass::number_of_way(bool masked) const {
  switch (way_.method) {
    case ShadowMethod::off:
      return FIRE3DV_SHADOWS_OFF;
    case ShadowMethod::map:
      return FIRE3DV_SHADOWS_MAP;
    default:
      return masked ? FIRE3DV_SHADOWS_MASK : FIRE3DV_SHADOWS_INLINE;
  }
}

ClusterRaster* ShadowPass::prepare_maps(gpu::StagingRing& belt, GpuScene& scene, VkDeviceAddress globals,
                                        Cull cull, bool levels_of_detail) {
  if (state_.view_count == 0) return nullptr;
  ClusterRaster::Job job;
  job.scene = &scene;
  job.views_written = &state_.views;
  job.target = &state_.maps;
  job.target_bytes = map_bytes();
  job.views = state_.views.address;
  job.globals = globals;
  job.view_count = state_.view_count;
  for (const gpu_types::LightViewWanted& view : state_.plan.views)
    job.extent = {std::max(job.extent.width, view.size), std::max(job.extent.height, view.size)};
  job.cull = cull;
  job.levels_of_detail = levels_of_detail;
  map_raster_->begin(belt, job);
  return &*map_raster_;
}

void ShadowPass::place_maps(gpu::Recorder& recorder, gpu::StagingRing& belt, GpuScene& scene,
                            std::span<const VkDeviceAddress> globals, bool levels_of_detail,
                            ClusterRaster::Emptying beside) {
  std::vector<Use> uses = std::move(beside.uses);
  uses.emplace_back(state_.views, access::compute_write);
  scene.add_reads(uses, access::compute_read);
  recorder.pass("light views", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, light_views_.get());
    gpu_types::LightViewsPush push{};
    push.globals = globals[0];
    push.cameras = belt.write(globals).address;
    push.wanted = state_.wanted_views.address;
    push.views = state_.views.address;
    push.sheets = state_.sheets.address;
    push.view_count = state_.view_count;
    push.levels_of_detail = levels_of_detail ? 1 : 0;
    push.camera_count = static_cast<uint32_t>(globals.size());
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    constexpr uint32_t kThreads = FIRE3DV_LIGHT_VIEW_THREADS;
    vkCmdDispatch(commands, state_.view_count + (scene.part_count + kThreads - 1) / kThreads, 1, 1);
    beside.commands(commands);
  });
}

bool ShadowPass::finds_while_shading(const ShadowPlan& plan) const {
  return way_.hybrid && plan.all_hard() && plan.mask_words == 1;
}

bool ShadowPass::found_while_shading() const {
  return traces() && finds_while_shading(state_.plan);
}

gpu_types::ShadowPush ShadowPass::push(const Visibility& visibility, VkDeviceAddress globals) const {
  return {globals,
          visibility.address,
          lists_.address,
          targets_->shadow_entries.address,
          targets_->found_rays.address,
          found_room(),
          way_.hybrid ? 1u : 0u};
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
  if (!classify_)
    make_classify();  // for the forward path, in configurations where shading usually resolves
                      // shadows
  std::vector<Use> uses{Use(visibility.buffer, access::compute_read), Use(lists_, access::compute_write),
                        Use(entries(), access::compute_write), Use(mask(), access::compute_write)};
  scene.add_reads(uses, access::compute_read);
  add_map_reads(uses, access::compute_read);
  recorder.pass("classify", uses, [&](VkCommandBuffer commands) {
    bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, classify_.get(), scene, push(visibility, globals));
    vkCmdDispatch(commands, (targets_->extent.width + 7) / 8, (targets_->extent.height + 7) / 8,
                  state_.plan.mask_words);
  });
  trace(recorder, scene, visibility, globals, false);
}

void ShadowPass::empty_lists(gpu::Recorder& recorder) {
  if (!traces()) return;
  recorder.transition({Use(lists_, access::transfer_write)});
  vkCmdUpdateBuffer(recorder.commands(), lists_.get(), 0, sizeof(kEmptyLists), kEmptyLists);
}

uint32_t ShadowPass::found_room() const {
  if (way_.most_found) return way_.most_found;
  return std::max(1u, targets_->extent.width * targets_->extent.height / 2);
}

void ShadowPass::trace_found(gpu::Recorder& recorder, GpuScene& scene, const Visibility& visibility,
                             VkDeviceAddress globals) {
  trace(recorder, scene, visibility, globals, true);
}

void ShadowPass::record_trace(VkCommandBuffer commands, const Tracing& tracing, uint32_t list,
                              GpuScene& scene, const gpu_types::ShadowPush& push) const {
  const VkDeviceSize offset = list * sizeof(gpu_types::RayList);
  if (way_.back_end == RayBackEnd::query) {
    bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, tracing.query.get(), scene, push);
    if (list == FIRE3DV_LIST_FOUND) {
      const bool cpu = device_.report().type == gpu::DeviceType::software;
      return vkCmdDispatch(commands, cpu ? kGroupsOfFoundOnCpu : kGroupsOfFound, 1, 1);
    }
    vkCmdDispatchIndirect(commands, lists_.get(), offset + offsetof(gpu_types::RayList, groups_x));
  } else {
    bind(commands, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, tracing.pipeline.get(), scene, push);
    tracing.pipeline.trace(commands, lists_.address + offset);
  }
}

void ShadowPass::trace(gpu::Recorder& recorder, GpuScene& scene, const Visibility& visibility,
                       VkDeviceAddress globals, bool found) {
  const bool query = way_.back_end == RayBackEnd::query;
  const gpu::Access read = query ? access::compute_read : access::ray_read;
  const gpu::Access write = query ? access::compute_write : access::ray_write;
  gpu::Access arguments = read;  // the list holds dispatch arguments and input
  arguments.stages |= access::indirect_read.stages;
  arguments.access |= access::indirect_read.access;
  std::vector<Use> uses{Use(visibility.buffer, read), Use(lists_, arguments), Use(entries(), read),
                        Use(mask(), write),
                        Use(scene.top_level.storage(), query ? access::compute_trace : access::ray_trace)};
  scene.add_reads(uses, read);
  if (found) uses.emplace_back(targets_->found_rays, read);
  recorder.pass("trace", uses, [&](VkCommandBuffer commands) {
    const gpu_types::ShadowPush what = push(visibility, globals);
    if (found) record_trace(commands, trace_found_, FIRE3DV_LIST_FOUND, scene, what);
    record_trace(commands, trace_pixels_, found ? FIRE3DV_LIST_LEFT : FIRE3DV_LIST_PIXELS, scene, what);
  });
  gpu::Buffer& seen = lists_seen_[frame_++ % gpu::kFramesInFlight];
  gpu_types::RayList last[FIRE3DV_RAY_LISTS];
  std::memcpy(last, seen.mapped, sizeof(last));
  rays_traced_ = uint64_t{last[FIRE3DV_LIST_PIXELS].rays} + last[FIRE3DV_LIST_FOUND].width;
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
