#include "renderer/scene/model/exposure_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "renderer/scene/model/scene_edits.h"
#include "renderer/scene/model/surface_area.h"

namespace fire3dv::scene {
namespace {

constexpr float kUsualMin = 0.08f, kUsualMax = 1.2f;  // radiance that the tone mapping shows well
constexpr float kMaxExposure = 1e4f, kMinExposure = 1e-6f;
constexpr float kSurfaceAlbedo = 0.5f;

float luminance(const glm::vec3& linear) {  // Rec. 709
  return glm::dot(linear, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

// Light at rest. The distance to a lamp counts as at least a quarter of the scene's radius: a lamp within the
// scene lights more than one point.
struct RestLight {
  const Light* light;
  glm::vec3 position_world, axis_world;  // axis: direction of directional lights and of cones
  float power, min_distance_m;

  // Illuminance of a surface with this normal; without one (zero), of a surface that faces the light.
  float illuminance_at(const glm::vec3& point, const glm::vec3& normal) const {
    const bool is_lamp = light->type != LightType::directional;
    const glm::vec3 offset = position_world - point;
    const float distance_m = std::max(glm::length(offset), 1e-6f);
    const glm::vec3 to_light = is_lamp ? offset / distance_m : -axis_world;
    const float cosine = normal == glm::vec3(0) ? 1 : std::max(glm::dot(normal, to_light), 0.0f);
    if (!is_lamp) return power * cosine;
    if (light->range_m > 0 && distance_m > light->range_m) return 0;
    const bool has_cone = light->type == LightType::spot && normal != glm::vec3(0);
    if (has_cone && glm::dot(axis_world, -to_light) < std::cos(light->outer_cone_rad)) return 0;
    const float distance = std::max(distance_m, min_distance_m);
    return power * cosine / (distance * distance);
  }
};

RestLight at_rest(const PlacedLight& placed, const glm::mat4& world_from_node, float radius_m) {
  const Light& light = placed.light;
  const glm::vec3 back(world_from_node[2]);
  const glm::vec3 axis = glm::length(back) > 0 ? -glm::normalize(back) : glm::vec3(0, 0, -1);
  return {&light, glm::vec3(world_from_node[3]), axis, light.intensity * luminance(light.color),
          std::max(0.25f * radius_m, 1e-3f)};
}

bool is_inside(const Scene& scene, const RestLight& light) {
  const glm::vec3& p = light.position_world;
  return light.light->type != LightType::directional && glm::all(glm::greaterThan(p, scene.bounds_min)) &&
         glm::all(glm::lessThan(p, scene.bounds_max));
}

// Calls visit(node, primitive) for all triangle meshes but unbounded ones.
template <typename Visit>
void for_each_mesh(const Scene& scene, Visit&& visit) {
  for (const Node& node : scene.nodes) {
    if (node.mesh == kNone || scene.meshes[node.mesh].unbounded) continue;
    const Mesh& mesh = scene.meshes[node.mesh];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      if (scene.primitives[p].topology == Topology::triangles) visit(node, scene.primitives[p]);
    }
  }
}

// Surface points that a view shows: of points spread evenly over all surfaces, the nearest in each cell of a
// grid. The camera's image, coarsely, without drawing it.
class SeenPoints {
 public:
  struct Point {
    float depth = std::numeric_limits<float>::max();  // clip space w
    glm::vec3 position_world, normal_world;           // the side that is seen
    float albedo;
  };

  SeenPoints(const Scene& scene, const SeenFrom& from) : from_(from), cells_(size_t{kSide} * kSide) {
    double area = 0;
    for_each_mesh(scene, [&](const Node& node, const Primitive& primitive) {
      area += surface_area(scene, primitive, node.world_from_node);
    });
    if (!(area > 0) || !std::isfinite(area)) return;
    double due = 0;
    for_each_mesh(scene, [&](const Node& node, const Primitive& primitive) {
      const Material& material = scene.materials[primitive.material];
      if (material.unlit || material.alpha_mode == AlphaMode::blend) return;
      const TriangleSample triangles(primitive);
      for (uint32_t t = 0; t < triangles.count; t += triangles.step) {
        const auto corners = triangle_corners(scene, primitive, t, node.world_from_node);
        due += area_of(corners) * triangles.step * kPoints / area;
        const bool is_mirrored = glm::determinant(glm::mat3(node.world_from_node)) < 0;
        for (; due >= 1; --due) add(corners, material, is_mirrored);
      }
    });
  }

  template <typename Visit>
  void for_each(Visit&& visit) const {
    for (const Point& point : cells_) {
      if (point.depth < std::numeric_limits<float>::max()) visit(point);
    }
  }

 private:
  static constexpr uint32_t kSide = 48;
  static constexpr double kPoints = 60'000;  // some 10 in each cell that shows a surface

  void add(const std::array<glm::vec3, 3>& corners, const Material& material, bool is_mirrored) {
    // Low-discrepancy sequence R2 in the unit square, folded into the triangle.
    ++count_;
    double u = std::fmod(0.7548776662466927 * count_, 1), v = std::fmod(0.5698402909980532 * count_, 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const glm::vec3 a = corners[1] - corners[0], b = corners[2] - corners[0];
    const glm::vec3 position = corners[0] + static_cast<float>(u) * a + static_cast<float>(v) * b;
    const glm::vec4 clip = from_.clip_from_world * glm::vec4(position, 1);
    if (!(clip.w > 0)) return;
    const glm::vec2 at = 0.5f * (glm::vec2(clip) / clip.w + 1.0f);
    if (!(at.x >= 0 && at.y >= 0 && at.x < 1 && at.y < 1)) return;
    Point& cell = cells_[static_cast<size_t>(at.y * kSide) * kSide + static_cast<size_t>(at.x * kSide)];
    if (clip.w >= cell.depth) return;
    glm::vec3 normal = glm::normalize(glm::cross(a, b));
    if (is_mirrored) normal = -normal;
    const bool is_front = glm::dot(normal, glm::vec3(from_.eye_world) - from_.eye_world.w * position) > 0;
    if (!is_front && !material.double_sided) return;
    // Metals scatter nothing. Their textures usually mix them with other materials.
    const float metal =
        material.metallic * (material.metallic_roughness_texture.texture != kNone ? 0.5f : 1.0f);
    cell = {clip.w, position, is_front ? normal : -normal, kSurfaceAlbedo * (1 - metal)};
  }

  SeenFrom from_;
  std::vector<Point> cells_;
  uint64_t count_ = 0;
};

// Mean over the area of all surfaces. Emissive textures count as white.
float mean_emitted_radiance(const Scene& scene) {
  const bool any = std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& material) {
    return luminance(material.emissive) > 0 && !material.unlit;
  });
  if (!any) return 0;
  double area = 0, emitted = 0;
  for_each_mesh(scene, [&](const Node& node, const Primitive& primitive) {
    const double share = surface_area(scene, primitive, node.world_from_node);
    area += share;
    emitted += share * luminance(scene.materials[primitive.material].emissive);
  });
  return area > 0 && std::isfinite(emitted / area) ? static_cast<float>(emitted / area) : 0;
}

// Mean over the seen points of the illuminance by these lamps, times the points' albedo relative to
// kSurfaceAlbedo. nullopt: nothing is seen.
std::optional<float> seen_illuminance(const Scene& scene, const std::vector<RestLight>& lamps,
                                      const SeenFrom& from) {
  double sum = 0;
  size_t count = 0;
  SeenPoints(scene, from).for_each([&](const SeenPoints::Point& point) {
    ++count;
    for (const RestLight& lamp : lamps)
      sum += point.albedo / kSurfaceAlbedo * lamp.illuminance_at(point.position_world, point.normal_world);
  });
  if (count == 0 || !std::isfinite(sum)) return std::nullopt;
  return static_cast<float>(sum / static_cast<double>(count));
}

}  // namespace

ExposureEstimate estimate_exposure(const Scene& scene, float environment_radiance,
                                   const std::function<SeenFrom()>& default_view) {
  ExposureEstimate estimate;
  const glm::vec3 center = 0.5f * (scene.bounds_min + scene.bounds_max);
  const float radius_m = 0.5f * glm::length(scene.bounds_max - scene.bounds_min);
  const std::vector<PlacedLight> placed = lights_of(scene, nullptr);
  std::vector<RestLight> inside;
  float at_center = 0;  // of the lamps inside
  for (const PlacedLight& each : placed) {
    const RestLight light = at_rest(each, scene.nodes[each.node].world_from_node, radius_m);
    const float illuminance = light.illuminance_at(center, glm::vec3(0));
    (is_inside(scene, light) ? at_center : estimate.illuminance_lux) += illuminance;
    if (is_inside(scene, light)) inside.push_back(light);
  }
  if (!inside.empty())
    estimate.illuminance_lux += seen_illuminance(scene, inside, default_view()).value_or(at_center);
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
