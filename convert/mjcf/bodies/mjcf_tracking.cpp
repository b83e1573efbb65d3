// Poses of cameras and lights, which follow their bodies or turn to others.
#include <cstddef>
#include <optional>

#include "convert/mjcf/bodies/mjcf_kinematics.h"

namespace fire3dv::convert {
namespace {

std::optional<size_t> target_of(const MjcfTree& tree, const MjcfTracked& tracked) {
  for (const std::string* name : {&tracked.target_in_scope, &tracked.target})
    if (const auto found = tree.body_index.find(*name); found != tree.body_index.end()) return found->second;
  return std::nullopt;
}

// Point that a camera or light turns to.
std::optional<glm::dvec3> target_point(const MjcfTree& tree, const MjcfTracked& tracked,
                                       const MjcfPosedBodies& posed) {
  if (tracked.mode != MjcfTracking::target_body && tracked.mode != MjcfTracking::target_mass)
    return std::nullopt;
  const std::optional<size_t> body = target_of(tree, tracked);
  if (!body) return std::nullopt;
  return tracked.mode == MjcfTracking::target_body ? posed.bodies[*body].position
                                                   : posed.subtree_masses[*body];
}

// Position that keeps its offset in the default pose from the body or its subtree's mass.
std::optional<glm::dvec3> tracked_position(MjcfTracking mode, size_t body, const glm::dvec3& at_rest,
                                           const MjcfPosedBodies& rest, const MjcfPosedBodies& posed) {
  if (mode == MjcfTracking::track) return at_rest + posed.bodies[body].position - rest.bodies[body].position;
  if (mode == MjcfTracking::track_mass)
    return at_rest + posed.subtree_masses[body] - rest.subtree_masses[body];
  return std::nullopt;
}

// Camera at `from` that looks at `to`, with +Z of the world up.
glm::dquat looking_at(const glm::dvec3& from, const glm::dvec3& to, const glm::dquat& otherwise) {
  if (glm::distance(from, to) < 1e-14) return otherwise;
  const glm::dvec3 back = glm::normalize(from - to);
  glm::dvec3 right = glm::cross(glm::dvec3(0, 0, 1), back);
  if (glm::length(right) < 1e-14) right = glm::dvec3(1, 0, 0);  // straight up or down
  right = glm::normalize(right);
  return glm::normalize(glm::quat_cast(glm::dmat3(right, glm::cross(back, right), back)));
}

}  // namespace

void pose_scene(const MjcfTree& tree, const MjcfPosedBodies& rest, const MjcfPosedBodies& posed,
                MjcfScene& scene) {
  for (size_t i = 0; i < tree.bodies.size(); ++i)
    scene.bodies.push_back({tree.bodies[i].name, tree.bodies[i].parent, posed.bodies[i]});
  for (const MjcfTreeGeom& geom : tree.geoms) scene.geoms.push_back(geom.geom);
  for (size_t i = 0; i < tree.cameras.size(); ++i) {
    MjcfCamera camera = tree.cameras[i];
    const MjcfTracked& tracked = tree.camera_tracking[i];
    const MjcfPose in_body = camera.world_pose, at_rest = rest.bodies[camera.body] * in_body;
    camera.world_pose = posed.bodies[camera.body] * in_body;
    if (const auto position = tracked_position(tracked.mode, camera.body, at_rest.position, rest, posed))
      camera.world_pose = {*position, at_rest.rotation};
    if (const auto point = target_point(tree, tracked, posed))
      camera.world_pose.rotation = looking_at(camera.world_pose.position, *point, camera.world_pose.rotation);
    scene.cameras.push_back(std::move(camera));
  }
  for (size_t i = 0; i < tree.lights.size(); ++i) {
    MjcfLight light = tree.lights[i];
    const MjcfTracked& tracked = tree.light_tracking[i];
    const glm::dvec3 at_rest = rest.bodies[light.body] * light.position, direction = light.direction;
    light.position = posed.bodies[light.body] * light.position;
    light.direction = posed.bodies[light.body].rotation * direction;
    if (const auto position = tracked_position(tracked.mode, light.body, at_rest, rest, posed)) {
      light.position = *position;
      light.direction = rest.bodies[light.body].rotation * direction;
    }
    if (const auto point = target_point(tree, tracked, posed); point && *point != light.position)
      light.direction = glm::normalize(*point - light.position);
    scene.lights.push_back(std::move(light));
  }
}

}  // namespace fire3dv::convert
