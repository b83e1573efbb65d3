#include "renderer/passes/post/sensor_pass.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "shaders/shared/bindings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

// Standard deviation of the fog's blur in cells of the coarse image.
constexpr float kBlurCells = 2;
constexpr float kMaxBlurCells = 16;

std::string light_shader(VkSampleCountFlagBits samples, bool is_path_traced, bool has_bloom) {
  std::string name = "camera_light";
  if (is_path_traced) {
    name += "_path";
  } else if (samples != VK_SAMPLE_COUNT_1_BIT) {
    name += "_multisampled";
  }
  return name + (has_bloom ? "_bloom.comp" : ".comp");
}

// SplitMix64 (Steele, Lea, Flood 2014).
uint64_t mixed(uint64_t state) {
  state += 0x9e3779b97f4a7c15;
  state = (state ^ state >> 30) * 0xbf58476d1ce4e5b9;
  state = (state ^ state >> 27) * 0x94d049bb133111eb;
  return state ^ state >> 31;
}

// Pixels of the focal length; of a view without one, those of its height.
float focal_px(const View& view, VkExtent2D extent) {
  if (view.orthographic) return static_cast<float>(extent.height);
  return static_cast<float>(extent.height) / (2 * glm::length(view.world_from_ndc_y));
}

}  // namespace

uint64_t frame_hash(const View& view, std::optional<int64_t> sim_time_ns) {
  uint64_t hash = mixed(static_cast<uint64_t>(sim_time_ns.value_or(0)) + (sim_time_ns ? 1 : 0));
  hash = mixed(hash ^ view.world);
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row)
      // Without the sign of zero.
      hash = mixed(hash ^ std::bit_cast<uint32_t>(view.clip_from_world[column][row] + 0.0f));
  return hash;
}

SensorPass::SensorPass(gpu::Device& device, VkSampleCountFlagBits samples, bool is_path_traced)
    : device_(device),
      samples_(samples),
      is_path_traced_(is_path_traced),
      sensor_(device, "sensor.comp", VK_FILTER_NEAREST),
      layout_(gpu::create_pipeline_layout(device, {})) {}

SensorPass::Grid SensorPass::grid_of(VkExtent2D extent, float focal, const settings::OpticsSettings& optics) {
  const float blur_px =
      std::max(focal * std::tan(optics.fog_blur_deg * std::numbers::pi_v<float> / 180), 0.1f);
  Grid grid;
  grid.block = static_cast<uint32_t>(
      std::clamp(blur_px / kBlurCells, 1.0f, static_cast<float>(std::max(extent.width, extent.height))));
  grid.width = (extent.width + grid.block - 1) / grid.block;
  grid.height = (extent.height + grid.block - 1) / grid.block;
  grid.blur_cells = std::min(blur_px / static_cast<float>(grid.block), kMaxBlurCells);
  return grid;
}

void SensorPass::allocate(Targets& targets, const View* view, const settings::PostSettings& settings) {
  const VkExtent2D extent = targets.extent;
  const VkDeviceSize light_bytes = VkDeviceSize{8} * extent.width * extent.height;
  gpu::grow_storage_buffer(device_, light_, light_bytes);
  const bool has_bloom = settings.bloom > 0;
  std::unique_ptr<ImageFilter>& filter = light_filters_[has_bloom];
  if (!filter)
    filter = std::make_unique<ImageFilter>(device_, light_shader(samples_, is_path_traced_, has_bloom),
                                           VK_FILTER_NEAREST);
  gpu::DescriptorSet& set = has_bloom ? targets.camera_light_bloom_set : targets.camera_light_set;
  if (set.get() == VK_NULL_HANDLE)
    set = filter->bind(is_path_traced_ ? nullptr : &targets.hdr, targets.display,
                       has_bloom ? &targets.bloom->levels.front() : nullptr);
  if (targets.sensor_set.get() == VK_NULL_HANDLE) targets.sensor_set = sensor_.bind(nullptr, targets.display);
  if (!settings.optics.condenses()) return;
  if (!condensation_) {
    const auto pipeline = [&](const char* shader) {
      return gpu::create_compute_pipeline(device_, layout_.get(), shader);
    };
    condensation_.emplace(Condensation{pipeline("fog_blocks.comp"), pipeline("fog_blur.comp"),
                                       pipeline("fog_means.comp"), pipeline("condensation.comp")});
  }
  gpu::grow_storage_buffer(device_, fogged_, light_bytes);
  gpu::grow_storage_buffer(device_, means_, 2 * sizeof(glm::vec4));
  if (!view) return;
  const Grid grid = grid_of(extent, focal_px(*view, extent), settings.optics);
  gpu::grow_storage_buffer(device_, grid_, 3 * grid.cells() * sizeof(glm::vec4));
}

gpu_types::SensorRecord SensorPass::describe(VkExtent2D extent, const Source& source) const {
  const View& view = source.view;
  const settings::PostSettings& post = source.settings;
  const settings::OpticsSettings& optics = post.optics;
  gpu_types::SensorRecord record{};
  record.sums = source.sums ? source.sums->address : 0;
  record.metered = source.metered.address;
  record.width = extent.width;
  record.height = extent.height;
  record.samples = samples_;
  record.exposure = post.exposure;
  record.bloom = post.bloom;
  record.ray_x = view.orthographic ? glm::vec3(0) : view.world_from_ndc_x;
  record.ray_y = view.orthographic ? glm::vec3(0) : view.world_from_ndc_y;
  record.ray_origin = view.orthographic ? view.look_world : view.world_from_ndc_origin;
  record.axis = view.look_world;
  record.focal_px = focal_px(view, extent);
  record.vignette = optics.vignette;
  record.mask_radius = optics.mask_radius;
  record.mask_cut = optics.mask_cut;
  record.aberration = optics.aberration;
  record.inverse_response = optics.response > 0 ? 1 / optics.response : 0;
  record.tone_map = tone_map_number(post);
  record.fog = optics.fog;
  record.fog_veil = optics.fog_veil;
  record.drops = optics.drops;
  record.drop_px = std::max(
      record.focal_px * 2 * std::tan(optics.drop_size_deg / 2 * std::numbers::pi_v<float> / 180), 1.0f);
  const Grid grid = grid_of(extent, record.focal_px, optics);
  record.block = grid.block;
  record.grid_width = grid.width;
  record.grid_height = grid.height;
  record.blur_cells = grid.blur_cells;
  record.full_well = optics.full_well;
  record.read_noise = optics.read_noise;
  record.dark_signal = optics.dark_signal;
  record.prnu = optics.prnu_percent / 100;
  record.dsnu = optics.dsnu;
  record.seed = optics.noise_seed;
  const uint64_t frame = frame_hash(view, source.sim_time_ns);
  record.frame_low = static_cast<uint32_t>(frame);
  record.frame_high = static_cast<uint32_t>(frame >> 32);
  return record;
}

void SensorPass::dispatch(gpu::Recorder& recorder, const char* name, gpu::Pipeline& pipeline,
                          const gpu_types::SensorPush& push, std::span<const Use> uses, VkExtent2D groups) {
  recorder.pass(name, uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
    vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, groups.width, groups.height, 1);
  });
}

void SensorPass::record_light(gpu::Recorder& recorder, gpu::StagingRing& staging, Targets& targets,
                              const Source& source) {
  allocate(targets, &source.view, source.settings);
  gpu_types::SensorRecord record = describe(targets.extent, source);
  record.light = light_.address;
  if (source.settings.optics.condenses()) {
    record.fogged = fogged_.address;
    record.grid = grid_.address;
    record.means = means_.address;
  }
  const gpu_types::SensorPush push{
      staging.write(std::span<const gpu_types::SensorRecord>(&record, 1)).address, 0};
  const bool has_bloom = source.settings.bloom > 0;
  std::vector<Use> uses{Use(light_, access::compute_write)};
  if (source.metered.buffer) uses.emplace_back(*source.metered.buffer, access::compute_read);
  if (source.sums) uses.emplace_back(*source.sums, access::compute_read);
  light_filters_[has_bloom]->record(recorder, "camera light",
                                    {source.sums ? nullptr : &targets.hdr, targets.display,
                                     has_bloom ? targets.camera_light_bloom_set : targets.camera_light_set,
                                     has_bloom ? &targets.bloom->levels.front() : nullptr},
                                    push, uses, targets.extent);
  shown_light_ = &light_;
  if (!source.settings.optics.condenses()) return;
  condense(recorder, push, record);
  shown_light_ = &fogged_;
}

void SensorPass::condense(gpu::Recorder& recorder, const gpu_types::SensorPush& push,
                          const gpu_types::SensorRecord& record) {
  const VkExtent2D cells{record.grid_width, record.grid_height};
  const VkExtent2D tiles{(cells.width + 7) / 8, (cells.height + 7) / 8};
  const Use read_light(light_, access::compute_read);
  std::vector<Use> uses_of_window{read_light, Use(fogged_, access::compute_write)};
  if (record.fog > 0) {
    dispatch(recorder, "fog blocks", condensation_->blocks, push,
             std::array{read_light, Use(grid_, access::compute_write)}, cells);
    for (const uint32_t along_rows : {1u, 0u})
      dispatch(recorder, "fog blur", condensation_->blur, {push.record, along_rows},
               std::array{Use(grid_, access::compute_write)}, tiles);
    dispatch(recorder, "fog means", condensation_->means, push,
             std::array{Use(grid_, access::compute_read), Use(means_, access::compute_write)}, {1, 1});
    uses_of_window.emplace_back(grid_, access::compute_read);
    uses_of_window.emplace_back(means_, access::compute_read);
  }
  dispatch(recorder, "condensation", condensation_->window, push, uses_of_window,
           {(record.width + 7) / 8, (record.height + 7) / 8});
}

void SensorPass::record_sensor(gpu::Recorder& recorder, gpu::StagingRing& staging,
                               gpu_types::SensorRecord record, gpu::Buffer& light, gpu::Image& out,
                               const gpu::DescriptorSet& set) {
  record.light = light.address;
  const gpu_types::SensorPush push{
      staging.write(std::span<const gpu_types::SensorRecord>(&record, 1)).address, 0};
  const Use read_light(light, access::compute_read);
  sensor_.record(recorder, "sensor", {nullptr, out, set}, push, std::span(&read_light, 1));
}

void SensorPass::develop(gpu::Recorder& recorder, gpu::StagingRing& staging, Targets& targets,
                         const Source& source) {
  record_sensor(recorder, staging, describe(targets.extent, source), light(), targets.display,
                targets.sensor_set);
}

gpu::Image& SensorPass::develop(gpu::Recorder& recorder, gpu::StagingRing& staging, gpu::Buffer& light,
                                VkExtent2D extent, const Source& source) {
  if (!developed_ || developed_.extent.width != extent.width || developed_.extent.height != extent.height) {
    developed_ = gpu::create_image(
        device_, {VK_FORMAT_R8G8B8A8_UNORM, extent,
                  VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT});
    developed_set_ = sensor_.bind(nullptr, developed_);
  }
  record_sensor(recorder, staging, describe(extent, source), light, developed_, developed_set_);
  return developed_;
}

MaskPlanesPass::MaskPlanesPass(gpu::Device& device)
    : layout_(gpu::create_pipeline_layout(device, {})),
      pipeline_(gpu::create_compute_pipeline(device, layout_.get(), "mask_planes.comp",
                                             gpu::Compile::on_first_use)) {}

void MaskPlanesPass::record(gpu::Recorder& recorder, gpu::Buffer& planes, std::span<const PlaneRange> places,
                            VkExtent2D extent, const settings::OpticsSettings& optics) {
  const uint64_t pixels = uint64_t{extent.width} * extent.height;
  recorder.pass("mask planes", {Use(planes, access::compute_write)}, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    for (const PlaneRange& place : places) {
      if (place.output == wire::kAmodal) continue;  // silhouettes are of what is hidden, too
      gpu_types::MaskPlanesPush push{};
      push.plane = planes.address + place.offset_bytes;
      push.width = extent.width;
      push.height = extent.height;
      push.words = static_cast<uint32_t>(place.size_bytes / pixels / sizeof(uint32_t));
      if (place.output == wire::kDepthF32) push.last = std::bit_cast<uint32_t>(HUGE_VALF);
      if (place.output == wire::kColorLinearF16) push.last = 0x3c000000;  // blue 0, and 1 as half floats
      push.mask_radius = optics.mask_radius;
      push.mask_cut = optics.mask_cut;
      vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      vkCmdDispatch(commands, (extent.width + 7) / 8, (extent.height + 7) / 8, 1);
    }
  });
}

}  // namespace fire3dv::passes
