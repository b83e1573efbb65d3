// Ray effects of the raster image: traces mirror and glossy reflections, ambient occlusion, refraction
// and one diffuse bounce of visible surfaces, for shading to read (shaders/ray_effects/ray_effects.glsl).
//
// Results depend on the frame alone: sample patterns are fixed, and no earlier image is read.
#pragma once

#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/shader_variant.h"
#include "renderer/passes/resources/targets.h"
#include "renderer/passes/view/view.h"
#include "renderer/settings/ray_effect_settings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

// Returns an error where the device cannot trace the rays, or the image has no visibility buffer.
Result<void> can_trace_ray_effects(const gpu::Device& device, bool has_visibility_buffer);

class RayEffectsPass {
 public:
  // samples: 1 or 4. The device traces rays.
  RayEffectsPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples,
                 settings::RayBackEnd preferred);

  settings::RayBackEnd back_end() const { return back_end_; }
  // Allocates targets.ray_effects. refracts: GpuScene::refracts. bounces: RayEffects::bounce.
  void allocate(Targets& targets, bool refracts, bool bounces) const;
  struct Frame {
    GpuScene& scene;
    Targets& targets;  // with the ids that shading reads
    const View& view;
    VkDeviceAddress globals = 0;
    float scene_radius_m = 0;  // at rest
  };
  // Light is refracted if the scene is made for it, whatever the settings.
  void record(gpu::Recorder& recorder, const Frame& frame, const settings::RayEffectSettings& settings);

 private:
  struct Variant {
    RayVariant scene;
    bool bounces = false;
    bool operator==(const Variant&) const = default;
  };

  void use_pipeline(const GpuScene& scene, bool bounces);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  uint32_t samples_;
  settings::RayBackEnd back_end_;
  gpu::Pipeline pipeline_;  // of ray queries
  gpu::RayPipeline ray_pipeline_;
  Variant variant_;
  gpu::Buffer trace_command_;  // VkTraceRaysIndirectCommandKHR: a ray-generation thread a pixel
};

}  // namespace fire3dv::passes
