#include "renderer/passes/shadow_pass.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <string>

#include "renderer/gpu/loader_commands.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

constexpr uint32_t kSoftRays = 16;
constexpr size_t kMostSheets = 16;
// All views together; beyond it every map gets smaller.
constexpr uint64_t kMostTexels = 48u << 20;
constexpr uint32_t kMapSide = 2048, kSmallestSide = 64;
// A spot that is wider than this has no map of one piece.
constexpr float kWidestSpotRad = 1.2f;

template <typename T>
gpu::Buffer upload_array(gpu::Device& device, gpu::LoaderCommands& loader, const std::vector<T>& values) {
  gpu::Buffer buffer = gpu::create_buffer(device, values.size() * sizeof(T),
                                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
  loader.upload(buffer, std::span<const T>(values));
  return buffer;
}

std::vector<scene::Light> lights_in_node_order(const scene::Scene& scene) {
  std::vector<scene::Light> lights;
  for (const scene::Node& node : scene.nodes) {
    if (node.light != scene::kNone) lights.push_back(scene.lights[node.light]);
  }
  return lights;
}

bool is_soft(const scene::Light& light) {
  return light.type == scene::LightType::directional ? light.angular_radius_rad > 0 : light.radius_m > 0;
}

bool needs_cube(const scene::Light& light) {
  return light.type == scene::LightType::point ||
         (light.type == scene::LightType::spot && light.outer_cone_rad > kWidestSpotRad);
}

}  // namespace

ShadowWay choose_shadow_way(const gpu::Device& device, const ShadowSettings& settings, bool compute) {
  ShadowWay way;
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
  const std::string suffix = samples == 4 ? "_4" : "_1";
  classify_ = gpu::create_compute_pipeline(device, layout, "classify" + suffix + ".comp");
  if (way.back_end == RayBackEnd::query) {
    trace_query_ = gpu::create_compute_pipeline(device, layout, "trace" + suffix + ".comp");
  } else {
    trace_pipeline_ =
        gpu::RayPipeline(device, layout, "trace" + suffix + ".rgen", "trace.rmiss", "trace.rahit");
  }
  list_ = gpu::create_buffer(device, sizeof(gpu_types::RayList),
                             VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
                             gpu::Memory::device);
  for (gpu::Buffer& seen : list_seen_) {
    seen = gpu::create_buffer(device, sizeof(gpu_types::RayList), 0, gpu::Memory::readback);
    std::memset(seen.mapped, 0, sizeof(gpu_types::RayList));
  }
}

// With rays behind it, a finer map saves some of them. Without, more texels than the image has pixels show
// little: a map of 1024 for images of 640 x 480.
uint32_t ShadowPass::map_side() const {
  if (way_.method != ShadowMethod::map || extent_.width == 0) return kMapSide;
  const uint32_t pixels = std::max(extent_.width, extent_.height);
  return std::clamp(std::bit_ceil(pixels + pixels / 2), kMapSide / 2, kMapSide);
}

void ShadowPass::choose_views() {
  const std::vector<scene::Light>& lights = lights_;
  chosen_side_ = map_side();
  std::vector<gpu_types::LightViewWanted> wanted;
  std::vector<gpu_types::LightShadow> shadows;
  uint32_t bit = 0, soft_words = 0;
  for (uint32_t i = 0; i < lights.size(); ++i) {
    const bool cube = needs_cube(lights[i]);
    gpu_types::LightShadow shadow{};
    shadow.first_view = static_cast<uint32_t>(wanted.size());
    shadow.rays = is_soft(lights[i]) ? kSoftRays : 1;
    // A map knows of one ray to each point; for soft shadows all rays are traced where they can be.
    shadow.view_count = shadow.rays > 1 && way_.method == ShadowMethod::ray ? 0 : cube ? 6 : 1;
    if (shadow.rays == 1) {
      shadow.mask_word = bit / 32;
      shadow.mask_shift = bit % 32;
      bit += samples_;
    } else {
      shadow.mask_word = soft_words++;  // counted from the last hard one; set right below
    }
    for (uint32_t side = 0; side < shadow.view_count; ++side) {
      wanted.push_back({i, cube ? side : FIRE3DV_NO_INDEX, cube ? chosen_side_ / 2 : chosen_side_, 0,
                        lights[i].outer_cone_rad});
    }
    shadows.push_back(shadow);
  }
  const uint32_t hard_words = (bit + 31) / 32;
  for (gpu_types::LightShadow& shadow : shadows) {
    if (shadow.rays != 1) shadow.mask_word += hard_words;
  }
  mask_words_ = std::max(1u, hard_words + soft_words);
  all_hard_ = soft_words == 0;

  // The outer map is for those who can trace what it cannot tell.
  const uint32_t maps_of_view = way_.hybrid ? 2 : 1;
  auto texels = [&] {
    uint64_t sum = 0;
    for (const gpu_types::LightViewWanted& view : wanted)
      sum += uint64_t{maps_of_view} * view.size * view.size;
    return sum;
  };
  while (texels() > kMostTexels && !wanted.empty() && wanted[0].size > kSmallestSide) {
    for (gpu_types::LightViewWanted& view : wanted) view.size /= 2;
  }
  uint32_t first_texel = 0;
  for (gpu_types::LightViewWanted& view : wanted) {
    view.first_texel = first_texel;
    first_texel += maps_of_view * view.size * view.size;
  }
  light_count_ = static_cast<uint32_t>(lights.size());
  view_count_ = needs_maps_ ? static_cast<uint32_t>(wanted.size()) : 0;

  gpu::LoaderCommands loader(device_);
  light_shadows_ = upload_array(device_, loader, shadows);
  wanted_views_ = upload_array(device_, loader, wanted);
  loader.finish();
  if (view_count_ == 0) return;
  maps_ = gpu::create_buffer(device_, VkDeviceSize{first_texel} * sizeof(uint32_t),
                             VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

void ShadowPass::choose_sheets(const scene::Scene& scene, const GpuScene& gpu_scene) {
  std::vector<gpu_types::SheetRecord> sheets;
  const float scene_radius = 0.5f * glm::length(scene.bounds_max - scene.bounds_min);
  for (const PlanarPart& planar : gpu_scene.planar_parts) {
    if (sheets.size() == kMostSheets) break;
    // Maps alone have to hold all that could shadow; a ground that is most of the scene would leave nothing
    // for the rest.
    if (way_.method == ShadowMethod::map && planar.radius_m < 0.5f * scene_radius) break;
    sheets.push_back({planar.plane_node, planar.part});
  }
  sheet_count_ = needs_maps_ ? static_cast<uint32_t>(sheets.size()) : 0;
  gpu::LoaderCommands loader(device_);
  sheets_ = upload_array(device_, loader, sheets);
  loader.finish();
}

void ShadowPass::place_views(const GpuScene& gpu_scene) {
  if (!needs_maps_) return;
  const auto padded = [](VkDeviceSize size) { return (size + 255) / 256 * 256; };
  sheets_offset_ = padded(view_count_ * sizeof(gpu_types::RasterView));
  far_sides_offset_ = sheets_offset_ + padded(sheet_count_ * sizeof(gpu_types::SheetPlace));
  views_ =
      gpu::create_buffer(device_, far_sides_offset_ + padded(gpu_scene.part_count * sizeof(uint32_t)) + 256,
                         VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

void ShadowPass::set_scene(const scene::Scene& scene, const GpuScene& gpu_scene) {
  // What is drawn on top has no mask, and where there is no ray query it has nothing but maps.
  needs_maps_ = way_.method == ShadowMethod::map || way_.hybrid ||
                (way_.back_end == RayBackEnd::pipeline && gpu_scene.has_on_top);
  lights_ = lights_in_node_order(scene);
  choose_views();
  choose_sheets(scene, gpu_scene);
  place_views(gpu_scene);
  if (extent_.width) set_size(extent_);
}

void ShadowPass::set_size(VkExtent2D extent) {
  extent_ = extent;
  if (chosen_side_ != 0 && map_side() != chosen_side_) choose_views();
  if (way_.method != ShadowMethod::ray) return;
  const VkDeviceSize words = VkDeviceSize{extent.width} * extent.height * mask_words_;
  mask_ = gpu::create_buffer(device_, words * sizeof(uint32_t), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                             gpu::Memory::device);
  entries_ = gpu::create_buffer(device_, words * sizeof(gpu_types::RayEntry),
                                VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

void ShadowPass::describe_to(gpu_types::Globals& globals, bool masked) const {
  globals.light_shadows = light_shadows_.address;
  globals.light_views = views_.address;
  globals.shadow_maps = maps_.address;
  globals.shadow_mask = mask_.address;
  globals.sheets = views_.address + sheets_offset_;
  globals.far_sides = views_.address + far_sides_offset_;
  globals.sheet_count = sheet_count_;
  globals.mask_words = mask_words_;
  globals.shadows = way_.method == ShadowMethod::off   ? FIRE3DV_SHADOWS_OFF
                    : way_.method == ShadowMethod::map ? FIRE3DV_SHADOWS_MAP
                    : masked                           ? FIRE3DV_SHADOWS_MASK
                                                       : FIRE3DV_SHADOWS_INLINE;
}

ClusterRaster* ShadowPass::prepare_maps(gpu::Recorder& recorder, gpu::UploadBelt& belt, GpuScene& scene,
                                        VkDeviceAddress globals, Cull cull, bool levels_of_detail) {
  if (!needs_maps_) return nullptr;
  std::vector<Use> uses{Use(views_, access::compute_write)};
  scene.add_reads(uses, access::compute_read);
  recorder.pass("light views", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, light_views_.get());
    const gpu_types::LightViewsPush push{globals,         wanted_views_.address, views_.address,
                                         sheets_.address, view_count_,           levels_of_detail ? 1u : 0u};
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, view_count_ + (scene.part_count + 63) / 64, 1, 1);
  });
  if (view_count_ == 0) return nullptr;
  ClusterRaster::Job job;
  job.scene = &scene;
  job.views_written = &views_;
  job.target = &maps_;
  job.views = views_.address;
  job.globals = globals;
  job.view_count = view_count_;
  job.cull = cull;
  job.levels_of_detail = levels_of_detail;
  map_raster_->begin(belt, job);
  return &*map_raster_;
}

bool ShadowPass::found_while_shading() const {
  return traces() && way_.hybrid && all_hard_ && mask_words_ == 1;
}

gpu_types::ShadowPush ShadowPass::push(const gpu::Buffer& visibility, VkDeviceAddress globals) const {
  return {globals, visibility.address, list_.address, entries_.address, way_.hybrid ? 1u : 0u};
}

void ShadowPass::bind(VkCommandBuffer commands, VkPipelineBindPoint point, VkPipeline pipeline,
                      GpuScene& scene, const gpu_types::ShadowPush& push) const {
  vkCmdBindPipeline(commands, point, pipeline);
  const VkDescriptorSet set = scene.textures.set();
  vkCmdBindDescriptorSets(commands, point, layout_, 0, 1, &set, 0, nullptr);
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
}

void ShadowPass::record(gpu::Recorder& recorder, GpuScene& scene, gpu::Buffer& visibility,
                        VkDeviceAddress globals) {
  if (!traces()) return;
  begin_list(recorder);
  std::vector<Use> uses{Use(visibility, access::compute_read), Use(list_, access::compute_write),
                        Use(entries_, access::compute_write), Use(mask_, access::compute_write)};
  scene.add_reads(uses, access::compute_read);
  add_map_reads(uses, access::compute_read);
  recorder.pass("classify", uses, [&](VkCommandBuffer commands) {
    bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, classify_.get(), scene, push(visibility, globals));
    vkCmdDispatch(commands, (extent_.width + 7) / 8, (extent_.height + 7) / 8, mask_words_);
  });
  trace(recorder, scene, visibility, globals);
}

void ShadowPass::begin_list(gpu::Recorder& recorder) {
  recorder.transition({Use(list_, access::transfer_write)});
  vkCmdFillBuffer(recorder.commands(), list_.get(), 0, VK_WHOLE_SIZE, 0);
}

void ShadowPass::trace(gpu::Recorder& recorder, GpuScene& scene, gpu::Buffer& visibility,
                       VkDeviceAddress globals) {
  const bool query = way_.back_end == RayBackEnd::query;
  const gpu::Access read = query ? access::compute_read : access::ray_read;
  const gpu::Access write = query ? access::compute_write : access::ray_write;
  gpu::Access arguments = read;  // the list is argument and input at once
  arguments.stages |= access::indirect_read.stages;
  arguments.access |= access::indirect_read.access;
  std::vector<Use> uses{Use(visibility, read), Use(list_, arguments), Use(entries_, read), Use(mask_, write),
                        Use(scene.top_level.storage(), query ? access::compute_trace : access::ray_trace)};
  scene.add_reads(uses, read);
  recorder.pass("trace", uses, [&](VkCommandBuffer commands) {
    if (query) {
      bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, trace_query_.get(), scene, push(visibility, globals));
      vkCmdDispatchIndirect(commands, list_.get(), offsetof(gpu_types::RayList, groups_x));
    } else {
      bind(commands, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, trace_pipeline_.get(), scene,
           push(visibility, globals));
      trace_pipeline_.trace(commands, list_.address);
    }
  });
  gpu::Buffer& seen = list_seen_[frame_++ % gpu::kFramesInFlight];
  gpu_types::RayList last;
  std::memcpy(&last, seen.mapped, sizeof(last));
  rays_traced_ = last.rays;
  recorder.transition({Use(list_, access::transfer_read), Use(seen, access::transfer_write)});
  const VkBufferCopy copy{0, 0, sizeof(gpu_types::RayList)};
  vkCmdCopyBuffer(recorder.commands(), list_.get(), seen.get(), 1, &copy);
  recorder.transition({Use(seen, access::host_read)});
}

void ShadowPass::add_reads(std::vector<Use>& uses, const gpu::Access& access) {
  if (traces()) uses.emplace_back(mask_, access);
  add_map_reads(uses, access);
}

void ShadowPass::add_map_reads(std::vector<Use>& uses, const gpu::Access& access) {
  if (needs_maps_) uses.emplace_back(views_, access);
  if (view_count_) uses.emplace_back(maps_, access);
}

}  // namespace fire3dv::passes
