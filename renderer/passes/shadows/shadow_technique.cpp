#include "renderer/passes/shadows/shadow_technique.h"

#include "renderer/gpu/device/device.h"

namespace fire3dv::passes {

ShadowTechnique choose_shadow_technique(const gpu::Device& device, const ShadowSettings& settings,
                                        bool compute) {
  ShadowTechnique technique;
  technique.map_side = settings.map_side;
  technique.max_listed_rays = settings.max_listed_rays;
  if (settings.method == ShadowMethod::off) return technique;
  const gpu::DeviceReport& report = device.report();
  const bool can_trace = report.ray_query || report.ray_tracing_pipeline;
  if (settings.method == ShadowMethod::map || !can_trace) {
    technique.method = ShadowMethod::map;
    return technique;
  }
  technique.method = ShadowMethod::ray;
  const bool pipeline =
      report.ray_tracing_pipeline && (settings.back_end == RayBackEnd::pipeline || !report.ray_query);
  technique.hybrid = settings.hybrid && (compute || pipeline);
  technique.back_end = pipeline ? RayBackEnd::pipeline : RayBackEnd::query;
  return technique;
}

const char* describe(const ShadowTechnique& technique) {
  switch (technique.method) {
    case ShadowMethod::off:
    case ShadowMethod::automatic:
      return "nothing";
    case ShadowMethod::map:
      return "shadow maps";
    case ShadowMethod::ray:
      break;
  }
  if (technique.back_end == RayBackEnd::query)
    return technique.hybrid ? "shadow maps and ray query" : "ray query";
  return technique.hybrid ? "shadow maps and a ray-tracing pipeline" : "a ray-tracing pipeline";
}

}  // namespace fire3dv::passes
