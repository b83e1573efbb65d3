#include "tools/lab/bench/bench_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "base/parallel.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/model/bounds.h"
#include "renderer/scene/model/vertices.h"

namespace fire3dv::bench {

namespace {

constexpr float kSpacingM = 2.6f;
constexpr float kRiseM = 0.2f;  // amplitude, times the body's scale
constexpr float kTurnRadPerStep = 0.03f, kRiseRadPerStep = 0.05f;
constexpr uint32_t kSharedMeshes = 8;
constexpr double kMaxUniqueTriangles = 16e6;  // bounds GPU memory and generation time

struct MeshPlan {
  Shape shape;
  uint32_t uses = 1;
};

struct Plan {
  std::vector<MeshPlan> meshes;
  std::vector<uint32_t> mesh_of_body;
};

// Assigns meshes: every second body is a box, and pairs of sphere and box alternate between shared and unique
// meshes.
Plan plan_meshes(const SceneSize& size, uint32_t bodies) {
  const double per_body = static_cast<double>(size.triangles) / bodies;
  const auto max_unique = static_cast<uint32_t>(std::min(kMaxUniqueTriangles / per_body, 1e9));
  Plan plan;
  plan.mesh_of_body.resize(bodies);
  std::vector<ShapeKind> kinds(std::min(kSharedMeshes, bodies));
  plan.meshes.resize(kinds.size());
  for (uint32_t m = 0; m < kinds.size(); ++m) {
    kinds[m] = m % 2 ? ShapeKind::box : ShapeKind::bumpy_sphere;
    plan.meshes[m].uses = 0;
  }
  uint32_t unique = 0;
  for (uint32_t b = 0; b < bodies; ++b) {
    const bool shares = b / 2 % 2 == 0 || unique >= max_unique;
    const auto kind = b % 2 ? ShapeKind::box : ShapeKind::bumpy_sphere;
    if (shares) {
      plan.mesh_of_body[b] = (b / 2 % (kSharedMeshes / 2) * 2 + b % 2) % static_cast<uint32_t>(kinds.size());
      plan.meshes[plan.mesh_of_body[b]].uses++;
    } else {
      ++unique;
      plan.mesh_of_body[b] = static_cast<uint32_t>(plan.meshes.size());
      plan.meshes.emplace_back();
      kinds.push_back(kind);
    }
  }
  // Each mesh compensates the triangle error of earlier ones. Spheres have the smallest error and come last.
  std::vector<uint32_t> order(plan.meshes.size());
  for (uint32_t m = 0; m < order.size(); ++m) order[m] = m;
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    if (plan.meshes[a].uses != plan.meshes[b].uses) return plan.meshes[a].uses > plan.meshes[b].uses;
    return kinds[a] > kinds[b];
  });
  double left = static_cast<double>(size.triangles) - 2;  // minus the ground's triangles
  uint32_t bodies_left = bodies;
  for (const uint32_t m : order) {
    MeshPlan& mesh = plan.meshes[m];
    mesh.shape = shape_of(kinds[m], left / std::max(bodies_left, 1u), 10'000 + m);
    left -= static_cast<double>(mesh.shape.triangles()) * mesh.uses;
    bodies_left -= mesh.uses;
  }
  return plan;
}

void add_ground(scene::Scene& out, float half) {
  const glm::vec3 corners[] = {{-half, 0, -half}, {-half, 0, half}, {half, 0, half}, {half, 0, -half}};
  scene::Primitive primitive;
  primitive.index_count = 6;
  primitive.vertex_count = 4;
  primitive.material = 1;
  primitive.bounds_min = {-half, 0, -half};
  primitive.bounds_max = {half, 0, half};
  for (const glm::vec3& corner : corners) {
    out.positions.push_back(corner);
    out.frames.push_back(scene::packed_frame({0, 1, 0}, {1, 0, 0, -1}));
    out.tangents.push_back(scene::kNoTangent);
    out.uvs.push_back(glm::vec2(corner.x, corner.z) / half);
  }
  out.indices = {0, 1, 2, 0, 2, 3};
  out.primitives.push_back(primitive);
  out.meshes.push_back({"ground", 0, 1, 0});
}

// One primitive per mesh; each mesh is generated once, however many bodies use it.
void add_meshes(scene::Scene& out, const Plan& plan) {
  const size_t first_primitive = out.primitives.size();
  size_t vertices = out.positions.size(), indices = out.indices.size();
  for (size_t m = 0; m < plan.meshes.size(); ++m) {
    const Shape& shape = plan.meshes[m].shape;
    scene::Primitive primitive;
    primitive.first_index = static_cast<uint32_t>(indices);
    primitive.index_count = 3 * shape.triangles();
    primitive.first_vertex = static_cast<uint32_t>(vertices);
    primitive.vertex_count = shape.vertices();
    primitive.material = 2 + static_cast<uint32_t>(m) % kMaterials;
    indices += primitive.index_count;
    vertices += primitive.vertex_count;
    out.meshes.push_back({"mesh_" + std::to_string(m), static_cast<uint32_t>(out.primitives.size()), 1, 0});
    out.primitives.push_back(primitive);
  }
  out.positions.resize(vertices);
  out.frames.resize(vertices);
  out.tangents.resize(vertices);
  out.uvs.resize(vertices);
  out.indices.resize(indices);
  parallel_for(plan.meshes.size(), [&](size_t m) {
    scene::Primitive& primitive = out.primitives[first_primitive + m];
    const std::span<glm::vec3> positions(out.positions.data() + primitive.first_vertex,
                                         primitive.vertex_count);
    const auto own = [&](auto& values) {
      return std::span(values).subspan(primitive.first_vertex, primitive.vertex_count);
    };
    make_shape(plan.meshes[m].shape,
               {positions, own(out.frames), own(out.tangents), own(out.uvs),
                std::span(out.indices).subspan(primitive.first_index, primitive.index_count)});
    scene::Box box;
    for (const glm::vec3& position : positions) box.add(position);
    primitive.bounds_min = box.low;
    primitive.bounds_max = box.high;
  });
}

scene::Node& add_node(scene::Scene& out, const std::string& name, const glm::mat4& world_from_node) {
  scene::Node& node = out.nodes.emplace_back();
  node.name = node.path = name;
  node.given_by_matrix = true;
  node.parent_from_node = node.world_from_node = world_from_node;
  return node;
}

std::vector<Body> place_bodies(uint32_t count, uint32_t side) {
  Random random(2);
  std::vector<Body> bodies(count);
  for (uint32_t b = 0; b < count; ++b) {
    Body& body = bodies[b];
    const auto coordinate = [&](uint32_t cell) {
      return kSpacingM * (static_cast<float>(cell) - static_cast<float>(side - 1) / 2) +
             random.uniform(-0.25f, 0.25f);
    };
    const float x = coordinate(b % side), z = coordinate(b / side);
    body.scale = random.uniform(0.75f, 1.05f);
    body.home_m = {x, 1.25f * body.scale, z};
    body.axis = random.direction();
    body.angle_rad = random.uniform(0, 3.14159265f);
    body.phase_rad = random.uniform(0, 6.28318531f);
  }
  return bodies;
}

// Adds a directional light, then spot lights around the scene. All cast shadows.
void add_lights(scene::Scene& out, uint32_t count, float extent) {
  for (uint32_t l = 0; l < count; ++l) {
    scene::Light light;
    glm::mat4 pose(1);
    if (l == 0) {
      light.name = "sun";
      light.type = scene::LightType::directional;
      light.color = {1, 0.96f, 0.9f};
      light.intensity = 2.5f;
      const glm::vec3 from(0, extent, 0);
      pose = passes::look_at_pose(from, from + glm::vec3(-0.5f, -1, -0.35f));
    } else {
      const float turn = 2.4f * static_cast<float>(l - 1);  // golden angle, so that no two lights share a
                                                            // direction
      const glm::vec3 first = glm::vec3(0.6f, 0.9f, 0.2f) * extent;
      const glm::vec3 from(std::cos(turn) * first.x + std::sin(turn) * first.z, first.y,
                           std::cos(turn) * first.z - std::sin(turn) * first.x);
      const float distance = glm::length(from);
      light.name = "lamp_" + std::to_string(l);
      light.type = scene::LightType::spot;
      light.color = {0.8f, 0.9f, 1};
      light.intensity = 1.5f * distance * distance;
      light.range_m = 4 * distance;
      light.inner_cone_rad = glm::radians(22.0f);
      light.outer_cone_rad = glm::radians(34.0f);
      pose = passes::look_at_pose(from, {0, 0, 0});
    }
    add_node(out, light.name, pose).light = static_cast<uint32_t>(out.lights.size());
    out.lights.push_back(light);
  }
}

}  // namespace

uint32_t bodies_for(uint64_t triangles) {
  const double bodies = 200 * std::cbrt(static_cast<double>(triangles) / 223e3);
  return static_cast<uint32_t>(std::clamp(std::round(bodies), 2.0, 4000.0));
}

BenchScene make_bench_scene(const SceneSize& size, const Surfaces& surfaces, float image_aspect) {
  const uint32_t count = size.bodies ? size.bodies : bodies_for(size.triangles);
  const auto side = static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  const float extent = kSpacingM * static_cast<float>(side);
  BenchScene made;
  scene::Scene& out = made.scene;
  out.images = surfaces.images;
  out.textures = surfaces.textures;
  out.materials = surfaces.materials;

  const Plan plan = plan_meshes(size, count);
  add_ground(out, 0.75f * extent);
  add_meshes(out, plan);
  add_node(out, "ground", glm::mat4(1)).mesh = 0;
  made.bodies = place_bodies(count, side);
  std::vector<wire::Affine3x4> rest;
  pose_bodies(made.bodies, 0, rest);
  made.triangles = 2;
  for (uint32_t b = 0; b < count; ++b) {
    glm::mat4 world_from_body(1);
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        world_from_body[column][row] = rest[b].m[static_cast<size_t>(row * 4 + column)];
    made.body_names.push_back("object_" + std::to_string(b));
    add_node(out, made.body_names.back(), world_from_body).mesh = 1 + plan.mesh_of_body[b];
    made.triangles += plan.meshes[plan.mesh_of_body[b]].shape.triangles();
  }
  made.unique_triangles = out.indices.size() / 3;

  add_lights(out, size.lights, extent);
  scene::Camera camera;
  camera.name = "camera";
  camera.vertical_fov_rad = kCameraFovRad;
  camera.near_m = 0.1f;
  out.cameras.push_back(camera);
  add_node(out, "camera", camera_pose(made.bodies, extent, image_aspect)).camera = 0;
  scene::find_world_bounds(out);
  return made;
}

void pose_bodies(const std::vector<Body>& bodies, uint64_t step,
                 std::vector<wire::Affine3x4>& world_from_body) {
  world_from_body.resize(bodies.size());
  const auto steps = static_cast<float>(step);
  for (size_t b = 0; b < bodies.size(); ++b) {
    const Body& body = bodies[b];
    const glm::mat4 turn = glm::rotate(glm::mat4(1), body.angle_rad + kTurnRadPerStep * steps, body.axis);
    const float rise = kRiseM * body.scale * 0.5f * (1 + std::sin(body.phase_rad + kRiseRadPerStep * steps));
    wire::Affine3x4& pose = world_from_body[b];
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        pose.m[static_cast<size_t>(row * 4 + column)] = turn[column][row] * body.scale;
      pose.m[static_cast<size_t>(row * 4 + 3)] = body.home_m[row] + (row == 1 ? rise : 0);
    }
  }
}

Reach reach_of(const Body& body) {
  const float half_rise = 0.5f * kRiseM * body.scale;
  return {body.home_m + glm::vec3(0, half_rise, 0), kMaxShapeRadiusM * body.scale + half_rise};
}

namespace {

// Computes the screen-space bounds of a body, as tangents of view angles. Returns false when it reaches
// behind the camera.
bool extent_in_view(const glm::mat4& camera_from_world, const Reach& reach, glm::vec2& low, glm::vec2& high) {
  const glm::vec3 c(camera_from_world * glm::vec4(reach.center_m, 1));
  if (-c.z <= reach.radius_m) return false;
  for (int axis = 0; axis < 2; ++axis) {
    const float center = std::atan2(c[axis], -c.z);
    const float half = std::asin(std::min(reach.radius_m / std::hypot(c[axis], c.z), 1.0f));
    if (std::abs(center) + half > 1.5f) return false;
    low[axis] = std::tan(center - half);
    high[axis] = std::tan(center + half);
  }
  return true;
}

// Computes the screen-space bounds of all bodies.
bool extent_in_view(const glm::mat4& world_from_camera, const std::vector<Body>& bodies, glm::vec2& low,
                    glm::vec2& high) {
  const glm::mat4 camera_from_world = glm::inverse(world_from_camera);
  low = glm::vec2(1e9f);
  high = glm::vec2(-1e9f);
  for (const Body& body : bodies) {
    glm::vec2 body_low, body_high;
    if (!extent_in_view(camera_from_world, reach_of(body), body_low, body_high)) return false;
    low = glm::min(low, body_low);
    high = glm::max(high, body_high);
  }
  return true;
}

}  // namespace

glm::mat4 camera_pose(const std::vector<Body>& bodies, float extent_m, float image_aspect) {
  const glm::vec3 towards = glm::normalize(glm::vec3(0.35f, 0.75f, 1));
  const float tan_y = std::tan(kCameraFovRad / 2) * 0.98f;
  const glm::vec2 most(tan_y * image_aspect, tan_y);
  glm::vec3 target(0);
  const auto pose = [&](float distance) { return passes::look_at_pose(target + towards * distance, target); };
  glm::vec2 low, high;
  const auto sees_all = [&](float distance) {
    return extent_in_view(pose(distance), bodies, low, high) && glm::all(glm::greaterThanEqual(low, -most)) &&
           glm::all(glm::lessThanEqual(high, most));
  };
  float distance = 0;
  for (int round = 0; round < 8; ++round) {
    float near = 0, far = extent_m + 10;
    // A very narrow image needs a distance that exceeds float precision.
    for (int i = 0; i < 20 && !sees_all(far); ++i) far *= 2;
    for (int i = 0; i < 24; ++i) {
      const float center = (near + far) / 2;
      (sees_all(center) ? far : near) = center;
    }
    distance = far;
    if (round == 7 || !sees_all(distance)) break;  // the last distance fits the last target
    const glm::vec2 off_center = (low + high) * 0.5f;
    const glm::mat4 axes = pose(distance);
    target += distance * (off_center.x * glm::vec3(axes[0]) + off_center.y * glm::vec3(axes[1]));
  }
  return pose(distance);
}

std::vector<glm::mat4> circle_of_cameras(const scene::Scene& scene, uint32_t count, float aspect) {
  std::vector<glm::mat4> world_from_camera;
  const glm::vec3 center = 0.5f * (scene.bounds_min + scene.bounds_max);
  const glm::mat4 first =
      passes::framing_camera_pose(scene::Camera(), aspect, scene.bounds_min, scene.bounds_max);
  const glm::vec3 from = glm::vec3(first[3]) - center;
  for (uint32_t i = 0; i < count; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / static_cast<float>(count);
    const float c = std::cos(angle), s = std::sin(angle);
    const glm::vec3 turned(c * from.x + s * from.z, from.y, c * from.z - s * from.x);
    world_from_camera.push_back(passes::look_at_pose(center + turned, center));
  }
  return world_from_camera;
}

}  // namespace fire3dv::bench
