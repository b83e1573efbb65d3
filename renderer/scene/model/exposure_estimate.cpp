#include "renderer/scene/model/exposure_estimate.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/scene/model/scene_edits.h"

namespace fire3dv::scene {
namespace {

constexpr float kUsualMin = 0.08f, kUsualMax = 1.2f;  // radiance that the tone mapping shows well
constexpr float kMaxExposure = 1e4f, kMinExposure = 1e-6f;
constexpr float kSurfaceAlbedo = 0.5f;

float luminance(const glm::vec3& linear) {  // Rec. 709
  return glm::dot(linear, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

// Illuminance at a point. The distance to a lamp is at least a quarter of the scene's radius: a lamp within
// the scene lights more than one point.
float illuminance_at(const PlacedLight& placed, const glm::mat4& world_from_node, const glm::vec3& center,
                     float radius_m) {
  const Light& light = placed.light;
  const float power = light.intensity * luminance(light.color);
  if (light.type == LightType::directional) return power;
  const glm::vec3 offset = center - glm::vec3(world_from_node[3]);
  const float distance_m = std::max({glm::length(offset), 0.25f * radius_m, 1e-3f});
  if (light.range_m > 0 && distance_m > light.range_m) return 0;
  return power / (distance_m * distance_m);
}

double area_of(const Scene& scene, const Primitive& primitive, const glm::mat4& world_from_node) {
  const glm::dmat3 linear(world_from_node);
  double area = 0;
  // A sample of the triangles suffices for a mean.
  const uint32_t triangles = primitive.index_count / 3, step = std::max(triangles / 4096, 1u);
  for (uint32_t t = 0; t < triangles; t += step) {
    glm::dvec3 corner[3];
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t vertex = primitive.first_vertex + scene.indices[primitive.first_index + 3 * t + k];
      corner[k] = linear * glm::dvec3(scene.positions[vertex]);
    }
    area += 0.5 * glm::length(glm::cross(corner[1] - corner[0], corner[2] - corner[0]));
  }
  return area * step;
}

// Mean over the area of all surfaces. Emissive textures count as white.
float mean_emitted_radiance(const Scene& scene) {
  const bool any = std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& material) {
    return luminance(material.emissive) > 0 && !material.unlit;
  });
  if (!any) return 0;
  double area = 0, emitted = 0;
  for (const Node& node : scene.nodes) {
    if (node.mesh == kNone) continue;
    const Mesh& mesh = scene.meshes[node.mesh];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      const Primitive& primitive = scene.primitives[p];
      if (primitive.topology != Topology::triangles) continue;
      const double share = area_of(scene, primitive, node.world_from_node);
      area += share;
      emitted += share * luminance(scene.materials[primitive.material].emissive);
    }
  }
  return area > 0 && std::isfinite(emitted / area) ? static_cast<float>(emitted / area) : 0;
}

}  // namespace

ExposureEstimate estimate_exposure(const Scene& scene, float environment_radiance) {
  ExposureEstimate estimate;
  const glm::vec3 center = 0.5f * (scene.bounds_min + scene.bounds_max);
  const float radius_m = 0.5f * glm::length(scene.bounds_max - scene.bounds_min);
  for (const PlacedLight& placed : lights_of(scene, nullptr))
    estimate.illuminance_lux +=
        illuminance_at(placed, scene.nodes[placed.node].world_from_node, center, radius_m);
  constexpr float kPi = std::numbers::pi_v<float>;
  estimate.radiance =
      kSurfaceAlbedo * (estimate.illuminance_lux / kPi + environment_radiance) + mean_emitted_radiance(scene);
  if (!std::isfinite(estimate.radiance) || estimate.radiance <= 0) return estimate;
  const float usual = std::clamp(estimate.radiance, kUsualMin, kUsualMax);
  if (usual != estimate.radiance)
    estimate.exposure = std::clamp(usual / estimate.radiance, kMinExposure, kMaxExposure);
  return estimate;
}

}  // namespace fire3dv::scene
