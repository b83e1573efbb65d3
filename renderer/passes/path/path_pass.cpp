#include "renderer/passes/path/path_pass.h"

#include <algorithm>
#include <chrono>

#include "base/plural.h"
#include "renderer/passes/path/environment_cells.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;
using Clock = std::chrono::steady_clock;

// Paths of one dispatch. A CPU also traces one ray of each path at a time: its loops end after 65535
// iterations (shaders/common/lanes.glsl).
constexpr uint32_t kBandPixels = 1 << 17, kBandPixelsOnCpu = 1 << 12;
// Durations of a submission that change the number of bands in the next one.
constexpr auto kShort = std::chrono::milliseconds(8), kLong = std::chrono::milliseconds(40);
constexpr uint32_t kMaxBandsPerSubmission = 64;
constexpr VkDeviceSize kCommandsOffset = 192, kGlobalsOffset = 256;
static_assert(sizeof(gpu_types::PathParameters) <= kCommandsOffset &&
              kCommandsOffset + 2 * sizeof(VkTraceRaysIndirectCommandKHR) <= kGlobalsOffset);

// Distance of the far plane; 0: infinite.
float far_distance(const View& view) {
  const glm::dvec4 z = glm::transpose(glm::dmat4(view.clip_from_world))[2];
  const double at_eye = glm::dot(z, glm::dvec4(view.eye_world, 1));
  const double change = glm::dot(glm::dvec3(z), glm::dvec3(view.look_world));
  return change < 0 ? static_cast<float>(-at_eye / change) : 0;
}

void set_origins(const View& view, gpu_types::PathParameters& parameters) {
  if (!view.orthographic) return;
  const glm::dmat4 world_from_clip = glm::inverse(glm::dmat4(view.clip_from_world));
  const auto at = [&](double x, double y) { return glm::dvec3(world_from_clip * glm::dvec4(x, y, 1, 1)); };
  parameters.origin_x = glm::vec3(0.5 * (at(1, 0) - at(-1, 0)));
  parameters.origin_y = glm::vec3(0.5 * (at(0, 1) - at(0, -1)));
}

void set_lens(const View& view, const scene::ThinLens& lens, gpu_types::PathParameters& parameters) {
  if (view.orthographic || lens.is_pinhole()) return;
  const float half_height = glm::length(view.world_from_ndc_y);  // at distance 1
  const float focal_length_m = scene::kSensorHeightM / 2 / half_height;
  const float radius_m = focal_length_m / lens.f_number / 2;
  parameters.lens_x_m = radius_m * glm::normalize(view.world_from_ndc_x);
  parameters.lens_y_m = radius_m * glm::normalize(view.world_from_ndc_y);
  parameters.focus_distance_m = lens.focus_distance_m;
}

settings::RayBackEnd choose_back_end(const gpu::Device& device, settings::RayBackEnd preferred) {
  const bool pipeline = device.report().ray_tracing_pipeline &&
                        (preferred == settings::RayBackEnd::pipeline || !device.ray_query());
  return pipeline ? settings::RayBackEnd::pipeline : settings::RayBackEnd::query;
}

// Everything that decides an image, as bytes. Buffers and counters of the raster do not.
std::vector<std::byte> make_key(gpu_types::Globals globals, gpu_types::PathParameters parameters,
                                const settings::RayBackEnd back_end) {
  globals.visibility_generation = globals.map_generation = globals.mask_words = 0;
  globals.light_views = globals.shadow_maps = globals.shadow_mask = 0;
  parameters.sums = parameters.states = 0;
  std::vector<std::byte> key{static_cast<std::byte>(back_end)};
  for (const auto bytes : {std::as_bytes(std::span(&globals, 1)), std::as_bytes(std::span(&parameters, 1))})
    key.insert(key.end(), bytes.begin(), bytes.end());
  return key;
}

gpu::Buffer create_storage(gpu::Device& device, VkDeviceSize bytes) {
  return gpu::create_buffer(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

}  // namespace

std::vector<std::string> path_tracing_limits(const scene::Scene& scene) {
  const auto thin =
      std::count_if(scene.primitives.begin(), scene.primitives.end(),
                    [](const auto& primitive) { return primitive.topology != scene::Topology::triangles; });
  const auto transmissive =
      std::count_if(scene.materials.begin(), scene.materials.end(), [](const scene::Material& material) {
        return material.transmission > 0 && !material.unlit && !scene::is_volume(material);
      });
  const auto volumes =
      std::count_if(scene.materials.begin(), scene.materials.end(), [](const scene::Material& material) {
        return material.transmission > 0 && scene::is_volume(material);
      });
  std::vector<std::string> limits;
  if (thin > 0)
    limits.push_back("paths: " + counted(static_cast<uint64_t>(thin), "primitive") +
                     " of lines or points left out; the raster draws them");
  if (transmissive > 0)
    limits.push_back("paths: " + counted(static_cast<uint64_t>(transmissive), "transmissive material") +
                     " let the light of lamps pass by chance only: smooth ones need many --spp");
  if (volumes > 0)
    limits.push_back("paths: no light of lamps through the smooth surfaces of " +
                     counted(static_cast<uint64_t>(volumes), "volume") +
                     " (no caustics); of the environment and of emissive surfaces it passes");
  return limits;
}

Result<void> can_trace_paths(const gpu::Device& device) {
  if (device.traces_rays()) return {};
  return Error{"path tracing needs ray queries or a ray-tracing pipeline, and " + device.report().name +
               " has neither: choose another device with --device"};
}

const char* describe_path_back_end(settings::RayBackEnd back_end) {
  return back_end == settings::RayBackEnd::pipeline ? "by a ray-tracing pipeline" : "by ray query";
}

PathPass::PathPass(gpu::Device& device, VkPipelineLayout layout, const settings::PathSettings& settings,
                   const scene::EnvironmentImage& environment)
    : device_(device),
      layout_(layout),
      settings_(settings),
      back_end_(choose_back_end(device, settings.back_end)),
      submissions_(device),
      resolve_(device, "path_resolve.comp", VK_FILTER_NEAREST) {
  const EnvironmentCells cells = make_environment_cells(environment);
  cells_size_ = cells.size;
  if (!cells.cells.empty()) {
    gpu::LoaderCommands loader(device);
    const std::span<const gpu_types::EnvironmentCell> values(cells.cells);
    cells_ = gpu::create_buffer(device, values.size_bytes(), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                gpu::filled_memory(device));
    loader.upload(cells_, values);
    loader.finish();
  }
}

void PathPass::select(uint64_t image) {
  if (image == selected_) return;
  last_.width = last_.height = 0;  // it is not shown for another image
  if (!current_.key.empty() && current_.samples() > 0) {
    others_.emplace_back(selected_, std::move(current_));
    current_ = {};
  }
  drop_selected();
  selected_ = image;
  const auto known = std::ranges::find(others_, image, &std::pair<uint64_t, Image>::first);
  if (known != others_.end()) {
    current_ = std::move(known->second);
    others_.erase(known);
  }
  if (others_.size() > kMaxOtherImages) others_.erase(others_.begin());
}

void PathPass::forget(uint64_t image) {
  std::erase_if(others_, [&](const auto& other) { return other.first == image; });
}

uint32_t PathPass::band_pixels() const {
  if (settings_.pixels_per_dispatch) return settings_.pixels_per_dispatch;
  return device_.report().type == gpu::DeviceType::software ? kBandPixelsOnCpu : kBandPixels;
}

void PathPass::allocate(uint64_t pixel_count, bool shows_previous_image) {
  const VkDeviceSize sum_bytes = pixel_count * sizeof(gpu_types::PathSum);
  const VkDeviceSize state_bytes =
      std::min<uint64_t>(band_pixels(), pixel_count) * sizeof(gpu_types::PathState);
  const auto grow = [&](Image& image) {
    if (image.sums.size_bytes >= sum_bytes) return;
    image = {};  // frees its memory first
    Image next;  // whole, or none
    next.sums = create_storage(device_, sum_bytes);
    next.constants = gpu::create_buffer(
        device_, kGlobalsOffset + sizeof(gpu_types::Globals),
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, gpu::Memory::device);
    image = std::move(next);
  };
  grow(current_);
  if (shows_previous_image) grow(last_);
  if (states_.size_bytes >= state_bytes) return;
  drop();  // their paths are in the old buffer
  states_ = create_storage(device_, state_bytes);
}

bool PathPass::shows_last() const {
  return current_.samples() == 0 && last_.samples() > 0 && last_.width == current_.width &&
         last_.height == current_.height;
}

settings::PathProgress PathPass::progress() const {
  return {current_.key.empty() ? 0 : current_.samples(), settings_.samples_per_pixel};
}

bool PathPass::has_begun(uint32_t width, uint32_t height) const {
  return !current_.key.empty() && current_.samples() == 0 && current_.width == width &&
         current_.height == height;
}

bool PathPass::is_current(const gpu_types::Globals& globals, const View& view) const {
  return current_.bands_done <= uint64_t{current_.bands} * settings_.samples_per_pixel &&
         current_.key == make_key(globals, make_parameters(globals, view), back_end_);
}

gpu_types::PathParameters PathPass::make_parameters(const gpu_types::Globals& globals,
                                                    const View& view) const {
  gpu_types::PathParameters parameters{};
  parameters.sums = current_.sums.address;
  parameters.states = states_.address;
  if (cells_ && globals.environment_intensity > 0) parameters.cells = cells_.address;
  parameters.cells_x = cells_size_.x;
  parameters.cells_y = cells_size_.y;
  set_origins(view, parameters);
  set_lens(view, lens_of(view, settings_.lens), parameters);
  parameters.look_world = view.look_world;
  parameters.near_m = view.near_m;
  parameters.far_m = far_distance(view);
  parameters.bounces = settings_.bounces;
  parameters.seed = settings_.seed;
  return parameters;
}

void PathPass::begin(gpu::Recorder& recorder, const gpu_types::Globals& globals, const View& view,
                     const std::optional<PathSamples>& resume) {
  const uint32_t pixel_count = globals.width * globals.height;
  const VkDeviceSize sum_bytes = VkDeviceSize{pixel_count} * sizeof(gpu_types::PathSum);
  if (current_.samples() > 0 && last_.sums.size_bytes >= sum_bytes) std::swap(current_, last_);
  FIRE3DV_ASSERT(current_.sums.size_bytes >= sum_bytes);
  const bool cpu = device_.report().type == gpu::DeviceType::software;
  current_.band_pixels = std::min(band_pixels(), pixel_count);
  current_.all_segments = settings_.bounces + 2;
  current_.segments = settings_.segments_per_dispatch ? settings_.segments_per_dispatch
                      : cpu                           ? 1
                                                      : current_.all_segments;
  current_.width = globals.width;
  current_.height = globals.height;
  current_.bands = (pixel_count + current_.band_pixels - 1) / current_.band_pixels;
  current_.bands_done = 0;
  const gpu_types::PathParameters parameters = make_parameters(globals, view);
  current_.key = make_key(globals, parameters, back_end_);
  const uint32_t last_band = (pixel_count - 1) % current_.band_pixels + 1;
  const VkTraceRaysIndirectCommandKHR bands[] = {{current_.band_pixels, 1, 1}, {last_band, 1, 1}};
  gpu::Buffer &sums = current_.sums, &constants = current_.constants;
  gpu::StagingRing::Piece earlier;
  if (resume) {
    FIRE3DV_ASSERT(resume->sums.size() == sum_bytes && resume->samples <= settings_.samples_per_pixel);
    earlier = submissions_.staging().write(resume->sums);
    current_.bands_done = uint64_t{current_.bands} * resume->samples;
  }
  recorder.pass("path begin", {Use(constants, access::transfer_write), Use(sums, access::transfer_write)},
                [&](VkCommandBuffer commands) {
                  vkCmdUpdateBuffer(commands, constants.get(), 0, sizeof(parameters), &parameters);
                  vkCmdUpdateBuffer(commands, constants.get(), kCommandsOffset, sizeof(bands), bands);
                  vkCmdUpdateBuffer(commands, constants.get(), kGlobalsOffset, sizeof(globals), &globals);
                  const VkBufferCopy copy{earlier.offset, 0, sum_bytes};
                  if (earlier.mapped) {
                    vkCmdCopyBuffer(commands, earlier.buffer, sums.get(), 1, &copy);
                  } else {
                    vkCmdFillBuffer(commands, sums.get(), 0, sum_bytes, 0);
                  }
                });
}

void PathPass::use_pipeline(const GpuScene& scene) {
  const RayVariant wanted = RayVariant::of(scene);
  if ((pipeline_ || ray_pipeline_) && wanted == variant_) return;
  variant_ = wanted;
  const auto constants = wanted.shader.constants();
  const std::string name = wanted.extensions ? "path" : "path_core";
  if (back_end_ == settings::RayBackEnd::query) {
    pipeline_ = gpu::create_compute_pipeline(device_, layout_, name + ".comp", gpu::Compile::next, constants);
  } else {
    ray_pipeline_ = gpu::RayPipeline(device_, layout_, name + ".rgen", "path.rmiss", "path.rahit",
                                     "path.rchit", constants);
  }
}

void PathPass::record_sample(gpu::Recorder& recorder, GpuScene& scene, gpu_types::PathPush push) {
  const bool query = back_end_ == settings::RayBackEnd::query;
  const gpu::Access write = query ? access::compute_write : access::ray_write;
  gpu::Access read = query ? access::compute_read : access::ray_read;
  std::vector<Use> uses{Use(current_.sums, write), Use(states_, write),
                        Use(scene.top_level.storage(), query ? access::compute_trace : access::ray_trace)};
  scene.add_reads(uses, read);
  read.stages |= access::indirect_read.stages;  // the trace commands
  read.access |= access::indirect_read.access;
  uses.emplace_back(current_.constants, read);
  for (uint32_t segment = 0; segment < current_.all_segments; segment += current_.segments) {
    push.begins = segment == 0 ? 1 : 0;
    push.segments = std::min(current_.segments, current_.all_segments - segment);
    recorder.pass("paths", uses, [&](VkCommandBuffer commands) {
      const VkPipelineBindPoint point =
          query ? VK_PIPELINE_BIND_POINT_COMPUTE : VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR;
      vkCmdBindPipeline(commands, point, query ? pipeline_.get() : ray_pipeline_.get());
      const VkDescriptorSet set = scene.textures.set();
      vkCmdBindDescriptorSets(commands, point, layout_, 0, 1, &set, 0, nullptr);
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      if (query) {
        vkCmdDispatch(commands, (push.pixel_count + 63) / 64, 1, 1);
      } else {
        const VkDeviceSize band =
            push.pixel_count == current_.band_pixels ? 0 : sizeof(VkTraceRaysIndirectCommandKHR);
        ray_pipeline_.trace(commands, current_.constants.address + kCommandsOffset + band);
      }
    });
  }
}

void PathPass::save(const PathHooks& hooks) {
  const VkDeviceSize bytes = VkDeviceSize{current_.width} * current_.height * sizeof(gpu_types::PathSum);
  if (saved_.size_bytes < bytes) {
    try {
      saved_ = gpu::create_buffer(device_, bytes, 0, gpu::Memory::readback);
    } catch (const gpu::VulkanFailure& failure) {
      if (!gpu::is_out_of_memory(failure)) throw;
      return;  // the run goes on without this checkpoint
    }
  }
  saved_.use = {};  // its last use is over
  gpu::Recorder& recorder = submissions_.begin();
  recorder.pass("path sums read-back",
                {Use(saved_, access::transfer_write), Use(current_.sums, access::transfer_read)},
                [&](VkCommandBuffer commands) {
                  const VkBufferCopy copy{0, 0, bytes};
                  vkCmdCopyBuffer(commands, current_.sums.get(), saved_.get(), 1, &copy);
                });
  recorder.transition({Use(saved_, access::host_read)});
  device_.wait(submissions_.submit());
  hooks.save({current_.samples(), {static_cast<const std::byte*>(saved_.mapped), bytes}});
}

bool PathPass::trace(GpuScene& scene, const PathHooks& hooks) {
  use_pipeline(scene);
  const uint32_t pixel_count = current_.width * current_.height;
  const uint64_t total = uint64_t{current_.bands} * settings_.samples_per_pixel;
  const Clock::time_point entered = Clock::now();
  Clock::time_point saved = entered;
  while (current_.bands_done < total) {
    const Clock::time_point begun = Clock::now();
    const bool stops = hooks.should_stop && hooks.should_stop();
    const bool saves = hooks.save && (stops || begun - saved >= hooks.save_interval);
    const bool is_between_samples = current_.bands_done % current_.bands == 0;
    if (saves && is_between_samples && current_.samples() > 0) {
      save(hooks);
      saved = Clock::now();
    }
    if (stops && (!saves || is_between_samples)) return false;
    gpu::Recorder& recorder = submissions_.begin();  // waits for the last submission but one
    uint64_t end = std::min<uint64_t>(total, current_.bands_done + bands_per_submission_);
    // A checkpoint has the same number of samples of all pixels.
    if (saves) end = std::min(end, (uint64_t{current_.samples()} + 1) * current_.bands);
    for (; current_.bands_done < end; ++current_.bands_done) {
      const auto first = static_cast<uint32_t>(current_.bands_done % current_.bands) * current_.band_pixels;
      gpu_types::PathPush push{};
      push.globals = current_.constants.address + kGlobalsOffset;
      push.parameters = current_.constants.address;
      push.first_pixel = first;
      push.pixel_count = std::min(current_.band_pixels, pixel_count - first);
      push.sample_index = current_.samples();
      record_sample(recorder, scene, push);
    }
    (void)submissions_.submit();
    (void)submissions_.take_finished();  // GPU times are not used
    const Clock::duration taken = Clock::now() - begun;
    if (taken < kShort) bands_per_submission_ = std::min(2 * bands_per_submission_, kMaxBandsPerSubmission);
    if (taken > kLong) bands_per_submission_ = std::max(bands_per_submission_ / 2, 1u);
    if (hooks.progress) hooks.progress(current_.bands_done, total);
    if (hooks.budget && Clock::now() - entered >= *hooks.budget) break;
  }
  return true;
}

void PathPass::bind_bloom(Targets& targets) {
  if (!resolve_bloom_)
    resolve_bloom_ = std::make_unique<ImageFilter>(device_, "path_resolve_bloom.comp", VK_FILTER_NEAREST);
  targets.bloom->tone_map_set =
      resolve_bloom_->bind(nullptr, targets.display, &targets.bloom->levels.front());
}

void PathPass::resolve(gpu::Recorder& recorder, Targets& targets, const settings::PostSettings& post,
                       const PostPass::Linear& linear, const MeteredExposure& metered) {
  if (targets.path_set.get() == VK_NULL_HANDLE) targets.path_set = resolve_.bind(nullptr, targets.display);
  gpu::Buffer& sums = shown().sums;
  const gpu_types::PathResolvePush push{
      sums.address,          linear.address, metered.address,       targets.extent.width,
      targets.extent.height, post.exposure,  tone_map_number(post), post.bloom};
  std::vector<Use> buffers{Use(sums, access::compute_read)};
  if (linear.buffer) buffers.emplace_back(*linear.buffer, access::compute_write);
  if (metered.buffer) buffers.emplace_back(*metered.buffer, access::compute_read);
  if (post.bloom > 0) {
    BloomImages& bloom = *targets.bloom;
    resolve_bloom_->record(recorder, "path resolve",
                           {nullptr, targets.display, bloom.tone_map_set, &bloom.levels.front()}, push,
                           buffers);
  } else {
    resolve_.record(recorder, "path resolve", {nullptr, targets.display, targets.path_set}, push, buffers);
  }
}

}  // namespace fire3dv::passes
