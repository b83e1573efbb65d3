#include "renderer/passes/ray_effects/ray_effects_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "shaders/shared/bindings.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

settings::RayBackEnd choose_effect_back_end(const gpu::Device& device, settings::RayBackEnd preferred) {
  const bool pipeline = device.report().ray_tracing_pipeline &&
                        (preferred == settings::RayBackEnd::pipeline || !device.ray_query());
  return pipeline ? settings::RayBackEnd::pipeline : settings::RayBackEnd::query;
}

// Between neighbouring pixels at the image's centre; 0 for an orthographic view.
float pixel_angle_rad(const View& view, uint32_t height) {
  if (view.orthographic) return 0;
  return 2 * glm::length(view.world_from_ndc_y) / static_cast<float>(height);
}

}  // namespace

Result<void> can_trace_ray_effects(const gpu::Device& device, bool has_visibility_buffer) {
  if (!device.traces_rays())
    return Error{"ray effects need ray queries or a ray-tracing pipeline, and " + device.report().name +
                 " has neither: images are drawn without them; choose another device with --device"};
  if (!has_visibility_buffer)
    return Error{
        "ray effects need the visibility buffer, and images are drawn forward without them: leave --raster "
        "forward out, or choose a device with 64-bit atomics with --device"};
  return {};
}

RayEffectsPass::RayEffectsPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples,
                               settings::RayBackEnd preferred)
    : device_(device),
      layout_(layout),
      samples_(samples),
      back_end_(choose_effect_back_end(device, preferred)),
      trace_command_(gpu::create_buffer(
          device, sizeof(VkTraceRaysIndirectCommandKHR),
          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, gpu::Memory::device)) {}

void RayEffectsPass::allocate(Targets& targets, bool refracts, bool bounces) const {
  const VkDeviceSize surfaces = VkDeviceSize{targets.extent.width} * targets.extent.height * samples_;
  const VkDeviceSize bytes =
      surfaces * (sizeof(gpu_types::RayEffectRecord) + (refracts ? sizeof(uint64_t) : 0) +
                  (bounces ? sizeof(gpu_types::BouncedRecord) : 0));
  if (targets.ray_effects.size_bytes >= bytes) return;
  targets.ray_effects =
      gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

void RayEffectsPass::use_pipeline(const GpuScene& scene, bool bounces) {
  const Variant wanted{RayVariant::of(scene), bounces};
  if ((pipeline_ || ray_pipeline_) && wanted == variant_) return;
  variant_ = wanted;
  static_assert(FIRE3DV_VARIANT_BOUNCES == FIRE3DV_VARIANT_COUNT);
  std::array<uint32_t, FIRE3DV_VARIANT_BOUNCES + 1> constants{};
  std::ranges::copy(wanted.scene.shader.constants(), constants.begin());
  constants[FIRE3DV_VARIANT_BOUNCES] = wanted.bounces ? 1 : 0;
  const std::string name = std::string(wanted.scene.extensions ? "ray_effects" : "ray_effects_core") +
                           (samples_ == 4 ? "_4" : "_1");
  if (back_end_ == settings::RayBackEnd::query) {
    pipeline_ = gpu::create_compute_pipeline(device_, layout_, name + ".comp", gpu::Compile::next, constants);
  } else {
    ray_pipeline_ = gpu::RayPipeline(device_, layout_, name + ".rgen", "ray_effects.rmiss",
                                     "ray_effects.rahit", "ray_effects.rchit", constants);
  }
}

void RayEffectsPass::record(gpu::Recorder& recorder, const Frame& frame,
                            const settings::RayEffectSettings& settings) {
  GpuScene& scene = frame.scene;
  Targets& targets = frame.targets;
  use_pipeline(scene, settings.on.bounce);
  const bool query = back_end_ == settings::RayBackEnd::query;
  const uint32_t pixels = targets.extent.width * targets.extent.height;
  gpu_types::RayEffectsPush push{};
  push.globals = frame.globals;
  push.visibility = targets.visibility.buffer.address;
  push.records = targets.ray_effects.address;
  push.effects = (settings.on.reflections ? FIRE3DV_RAY_EFFECT_REFLECTIONS : 0u) |
                 (settings.on.ambient_occlusion ? FIRE3DV_RAY_EFFECT_OCCLUSION : 0u) |
                 (scene.refracts ? FIRE3DV_RAY_EFFECT_REFRACTION : 0u) |
                 (settings.on.bounce ? FIRE3DV_RAY_EFFECT_BOUNCE : 0u);
  push.reflection_rays = std::max(settings.reflection_rays, 1u);
  push.occlusion_rays = std::max(settings.occlusion_rays, 1u);
  push.bounce_rays = std::max(settings.bounce_rays, 1u);
  push.occlusion_distance_m =
      settings.occlusion_distance_m > 0 ? settings.occlusion_distance_m : 0.1f * frame.scene_radius_m;
  push.pixel_angle_rad = pixel_angle_rad(frame.view, targets.extent.height);

  if (!query) {
    const VkTraceRaysIndirectCommandKHR threads{pixels, 1, 1};
    recorder.pass("ray effects begin", {Use(trace_command_, access::transfer_write)},
                  [&](VkCommandBuffer commands) {
                    vkCmdUpdateBuffer(commands, trace_command_.get(), 0, sizeof(threads), &threads);
                  });
  }
  const gpu::Access read = query ? access::compute_read : access::ray_read;
  std::vector<Use> uses{Use(targets.visibility.buffer, read),
                        Use(targets.ray_effects, query ? access::compute_write : access::ray_write),
                        Use(scene.top_level.storage(), query ? access::compute_trace : access::ray_trace)};
  scene.add_reads(uses, read);
  if (!query) uses.emplace_back(trace_command_, access::indirect_read);
  recorder.pass("ray effects", uses, [&](VkCommandBuffer commands) {
    const VkPipelineBindPoint point =
        query ? VK_PIPELINE_BIND_POINT_COMPUTE : VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR;
    vkCmdBindPipeline(commands, point, query ? pipeline_.get() : ray_pipeline_.get());
    const VkDescriptorSet set = scene.textures.set();
    vkCmdBindDescriptorSets(commands, point, layout_, 0, 1, &set, 0, nullptr);
    // A CPU limits the loops of a thread (shaders/common/lanes.glsl), so each thread has one surface.
    for (push.surface = 0; push.surface < samples_; ++push.surface) {
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      if (query) {
        vkCmdDispatch(commands, (targets.extent.width + 7) / 8, (targets.extent.height + 7) / 8, 1);
      } else {
        ray_pipeline_.trace(commands, trace_command_.address);
      }
    }
  });
}

}  // namespace fire3dv::passes
