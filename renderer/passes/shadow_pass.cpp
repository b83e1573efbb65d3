#include "renderer/passes/shadow_pass.h"

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
// Of 64 threads, that take found rays in turns: more than fit on a GPU at once; on a CPU, whose threads get
// groups in advance, few that all have the same share, but of not too many turns (lanes.glsl).
constexpr uint32_t kGroupsOfFound = 1024, kGroupsOfFoundOnCpu = 64;
constexpr gpu_types::RayList kEmptyList{0, 1, 1, 0, 1, 1, 0};
constexpr gpu_types::RayList kEmptyLists[FIRE3DV_RAY_LISTS] = {kEmptyList, kEmptyList, kEmptyList};

gpu::Buffer table(gpu::Device& device, VkDeviceSize bytes) {
  return gpu::create_buffer(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

}  // namespace

ShadowWay choose_shadow_way(const gpu::Device& device, const ShadowSettings& settings, bool compute) {
  ShadowWay way;
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

const char* describe(const ShadowWay& way) {
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

ShadowPass::ShadowPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples, const ShadowWay& way)
    : device_(device), layout_(layout), samples_(samples), way_(way) {
  if (way.method != ShadowMethod::off) {
    light_views_ = gpu::create_compute_pipeline(device, layout, "light_views.comp");
    map_raster_.emplace(device, layout, way.hybrid ? RasterKind::lights : RasterKind::lights_middles);
  }
  if (way.method != ShadowMethod::ray) return;
  // Where shading finds the shadows, as it mostly does, nobody asks; and a CPU takes long to make this ready.
  if (!way.hybrid || !gpu::takes_cpu_variants(device)) make_classify();
  const std::string suffix = samples == 4 ? "_4" : "_1";
  const auto prepare = [&](Tracing& tracing, const std::string& variant) {
    if (way.back_end == RayBackEnd::query) {
      tracing.query = gpu::create_compute_pipeline(device, layout, "trace" + variant + ".comp");
    } else {
      tracing.pipeline =
          gpu::RayPipeline(device, layout, "trace" + variant + ".rgen", "trace.rmiss", "trace.rahit");
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

// Without rays behind it, a map with more texels than the image has pixels shows little: 1024 for images of
// 640 x 480. With them, a finer map saves rays; but a CPU draws its two maps about as slowly as it traces,
// and is done soonest when there are about as many texels as pixels. The outer map is for those who can trace
// what it cannot tell.
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

void ShadowPass::set_lights(const std::vector<scene::PlacedLight>& lights) {
  lights_ = lights;
  light_count_ = static_cast<uint32_t>(lights.size());
  ShadowPlan plan = plan_shadows(lights, samples_, way_.method == ShadowMethod::ray, map_sizes());
  if (lights_placed_ && light_shadows_ && plan == plan_) return;
  lights_placed_ = false;
  plan_ = std::move(plan);
  if (traces() && !found_while_shading() && !classify_) make_classify();
  view_count_ = needs_maps_ ? static_cast<uint32_t>(plan_.views.size()) : 0;
  // New ones: frames in flight read the old ones. Maps are kept where they suffice: the next frame draws them
  // behind a barrier.
  light_shadows_ = table(device_, plan_.shadows.size() * sizeof(plan_.shadows[0]));
  wanted_views_ = table(device_, plan_.views.size() * sizeof(plan_.views[0]));
  lights_chosen_ = true;
  make_room_for_mask();
  if (view_count_ && maps_.buffer.size_bytes < map_bytes()) {
    gpu::Buffer maps = table(device_, map_bytes());
    maps_ = {};
    maps_.buffer = std::move(maps);
  }
  place_views();
  lights_placed_ = true;
}

void ShadowPass::choose_sheets(const scene::Scene& scene, const GpuScene& gpu_scene) {
  sheet_records_.clear();
  const float scene_radius = 0.5f * glm::length(scene.bounds_max - scene.bounds_min);
  for (const PlanarPart& planar : gpu_scene.planar_parts) {
    if (sheet_records_.size() == kMostSheets) break;
    if (gpu_scene.is_hidden(planar.node)) continue;
    // Maps alone have to hold all that could shadow; a ground that is most of the scene would leave nothing
    // for the rest.
    if (way_.method == ShadowMethod::map && planar.radius_m < 0.5f * scene_radius) break;
    sheet_records_.push_back({planar.plane_node, planar.part});
  }
  sheet_count_ = needs_maps_ ? static_cast<uint32_t>(sheet_records_.size()) : 0;
  sheets_ = table(device_, sheet_records_.size() * sizeof(sheet_records_[0]));
  sheets_chosen_ = true;
  place_views();
}

void ShadowPass::place_views() {
  if (!needs_maps_) return;
  const auto padded = [](VkDeviceSize size) { return (size + 255) / 256 * 256; };
  sheets_offset_ = padded(view_count_ * sizeof(gpu_types::RasterView));
  far_sides_offset_ = sheets_offset_ + padded(sheet_count_ * sizeof(gpu_types::SheetPlace));
  const VkDeviceSize bytes = far_sides_offset_ + padded(part_count_ * sizeof(uint32_t)) + 256;
  if (!views_ || views_.size_bytes != bytes) views_ = table(device_, bytes);
}

void ShadowPass::set_scene(const scene::Scene& scene, const GpuScene& gpu_scene) {
  // What is drawn on top has no mask, and where there is no ray query it has nothing but maps.
  needs_maps_ = way_.method == ShadowMethod::map || way_.hybrid ||
                (way_.back_end == RayBackEnd::pipeline && gpu_scene.has_on_top);
  part_count_ = gpu_scene.part_count;
  light_shadows_ = {};
  maps_ = {};
  set_lights(scene::lights_of(scene, nullptr));
  choose_sheets(scene, gpu_scene);
}

void ShadowPass::upload_choices(gpu::Recorder& recorder, gpu::UploadBelt& belt) {
  if (!lights_chosen_ && !sheets_chosen_) return;
  // Of what was chosen several times before a frame came, the last counts.
  Patches choices;
  if (std::exchange(lights_chosen_, false)) {
    choices.write(light_shadows_, 0, std::span<const gpu_types::LightShadow>(plan_.shadows));
    choices.write(wanted_views_, 0, std::span<const gpu_types::LightViewWanted>(plan_.views));
  }
  if (std::exchange(sheets_chosen_, false))
    choices.write(sheets_, 0, std::span<const gpu_types::SheetRecord>(sheet_records_));
  choices.record(recorder, belt);
}

void ShadowPass::set_targets(Targets& targets) {
  targets_ = &targets;
  const bool other_maps = light_shadows_ && map_sizes() != plan_.sizes;
  if (other_maps || !lights_placed_) set_lights(std::vector(lights_));
  make_room_for_mask();
}

void ShadowPass::make_room_for_mask() {
  if (way_.method != ShadowMethod::ray || !targets_) return;
  if (way_.hybrid && plan_.all_hard() && plan_.mask_words == 1 && !targets_->found_rays)
    targets_->found_rays = table(device_, found_room() * sizeof(gpu_types::FoundRay));
  const VkDeviceSize words =
      VkDeviceSize{targets_->extent.width} * targets_->extent.height * plan_.mask_words;
  if (targets_->shadow_mask && targets_->shadow_mask.size_bytes == words * sizeof(uint32_t)) return;
  gpu::Buffer mask = table(device_, words * sizeof(uint32_t));
  targets_->shadow_entries = table(device_, words * sizeof(gpu_types::RayEntry));
  targets_->shadow_mask = std::move(mask);
}

void ShadowPass::describe_to(gpu_types::Globals& globals) const {
  globals.light_shadows = light_shadows_.address;
  globals.light_views = views_.address;
  globals.shadow_maps = maps_.buffer.address;
  globals.map_generation = maps_.generation();
  globals.shadow_mask = targets_->shadow_mask.address;
  globals.sheets = views_.address + sheets_offset_;
  globals.far_sides = views_.address + far_sides_offset_;
  globals.sheet_count = sheet_count_;
  globals.mask_words = plan_.mask_words;
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

ClusterRaster* ShadowPass::prepare_maps(gpu::UploadBelt& belt, GpuScene& scene, VkDeviceAddress globals,
                                        Cull cull, bool levels_of_detail) {
  if (view_count_ == 0) return nullptr;
  ClusterRaster::Job job;
  job.scene = &scene;
  job.views_written = &views_;
  job.target = &maps_;
  job.target_bytes = map_bytes();
  job.views = views_.address;
  job.globals = globals;
  job.view_count = view_count_;
  for (const gpu_types::LightViewWanted& view : plan_.views)
    job.extent = {std::max(job.extent.width, view.size), std::max(job.extent.height, view.size)};
  job.cull = cull;
  job.levels_of_detail = levels_of_detail;
  map_raster_->begin(belt, job);
  return &*map_raster_;
}

void ShadowPass::place_maps(gpu::Recorder& recorder, gpu::UploadBelt& belt, GpuScene& scene,
                            std::span<const VkDeviceAddress> globals, bool levels_of_detail,
                            ClusterRaster::Emptying beside) {
  std::vector<Use> uses = std::move(beside.uses);
  uses.emplace_back(views_, access::compute_write);
  scene.add_reads(uses, access::compute_read);
  recorder.pass("light views", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, light_views_.get());
    gpu_types::LightViewsPush push{};
    push.globals = globals[0];
    push.cameras = belt.write(globals).address;
    push.wanted = wanted_views_.address;
    push.views = views_.address;
    push.sheets = sheets_.address;
    push.view_count = view_count_;
    push.levels_of_detail = levels_of_detail ? 1 : 0;
    push.camera_count = static_cast<uint32_t>(globals.size());
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    constexpr uint32_t kThreads = FIRE3DV_LIGHT_VIEW_THREADS;
    vkCmdDispatch(commands, view_count_ + (scene.part_count + kThreads - 1) / kThreads, 1, 1);
    beside.commands(commands);
  });
}

bool ShadowPass::found_while_shading() const {
  return traces() && way_.hybrid && plan_.all_hard() && plan_.mask_words == 1;
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
  if (!classify_) make_classify();  // for the forward path, which asks whatever shading could find
  std::vector<Use> uses{Use(visibility.buffer, access::compute_read), Use(lists_, access::compute_write),
                        Use(entries(), access::compute_write), Use(mask(), access::compute_write)};
  scene.add_reads(uses, access::compute_read);
  add_map_reads(uses, access::compute_read);
  recorder.pass("classify", uses, [&](VkCommandBuffer commands) {
    bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, classify_.get(), scene, push(visibility, globals));
    vkCmdDispatch(commands, (targets_->extent.width + 7) / 8, (targets_->extent.height + 7) / 8,
                  plan_.mask_words);
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
  gpu::Access arguments = read;  // the list is argument and input at once
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
  if (needs_maps_) uses.emplace_back(views_, access);
  if (view_count_) uses.emplace_back(maps_.buffer, access);
}

}  // namespace fire3dv::passes
