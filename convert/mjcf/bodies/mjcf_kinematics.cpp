#include "convert/mjcf/bodies/mjcf_kinematics.h"

#include <algorithm>
#include <cstddef>

namespace fire3dv::convert {
namespace {

constexpr double kMinMass = 1e-15;
constexpr double kInfinitePlaneRadius = 1;  // share of an infinite plane in the extent; metres

MjcfMass mass_of(const MjcfTreeBody& body) {
  if (body.given_mass && !body.takes_geom_mass) return *body.given_mass;
  return body.geom_mass;
}

glm::dquat unit_quat(const double* q) {
  const glm::dquat given(q[0], q[1], q[2], q[3]);
  const double length = glm::length(given);
  return length > 1e-15 ? given / length : glm::dquat(1, 0, 0, 0);
}

// Moves a body by its joints and records their anchors.
void apply_joints(const MjcfTreeBody& body, const std::vector<double>& values, MjcfPose& pose,
                  std::vector<glm::dvec3>& anchors) {
  for (const MjcfJoint& joint : body.joints) {
    const double* value = &values[joint.first_coordinate];
    if (joint.type == MjcfJoint::Type::free) {
      pose = {{value[0], value[1], value[2]}, unit_quat(value + 3)};
      anchors.push_back(pose.position);
      continue;
    }
    const glm::dvec3 anchor = pose * joint.position;
    anchors.push_back(anchor);
    if (joint.type == MjcfJoint::Type::slide) {
      pose.position += pose.rotation * joint.axis * (*value - joint.reference);
      continue;
    }
    const glm::dquat turn = joint.type == MjcfJoint::Type::ball
                                ? unit_quat(value)
                                : glm::angleAxis(*value - joint.reference, joint.axis);
    pose.rotation = glm::normalize(pose.rotation * turn);
    pose.position = anchor - pose.rotation * joint.position;
  }
}

// Bounding box that grows.
struct Box {
  glm::dvec3 low{1e10}, high{-1e10};
  void add(const glm::dvec3& centre, double radius = 0) {
    low = glm::min(low, centre - radius);
    high = glm::max(high, centre + radius);
  }
};

}  // namespace

MjcfCoordinates default_coordinates(const MjcfTree& tree) {
  MjcfCoordinates made;
  for (const MjcfTreeBody& body : tree.bodies) {
    for (const MjcfJoint& joint : body.joints) {
      const MjcfPose& pose = body.pose;
      if (joint.type == MjcfJoint::Type::free)
        for (const double v : {pose.position.x, pose.position.y, pose.position.z, pose.rotation.w,
                               pose.rotation.x, pose.rotation.y, pose.rotation.z})
          made.values.push_back(v);
      else if (joint.type == MjcfJoint::Type::ball)
        made.values.insert(made.values.end(), {1, 0, 0, 0});
      else
        made.values.push_back(joint.reference);
    }
  }
  return made;
}

MjcfPosedBodies pose_bodies(const MjcfTree& tree, const MjcfCoordinates& coordinates) {
  MjcfPosedBodies posed;
  const size_t count = tree.bodies.size();
  std::vector<MjcfMass> subtree(count);
  for (size_t i = 0; i < count; ++i) {
    const MjcfTreeBody& body = tree.bodies[i];
    MjcfPose pose = body.parent ? posed.bodies[*body.parent] * body.pose : body.pose;
    if (const auto mocap = coordinates.mocap.find(i); mocap != coordinates.mocap.end()) pose = mocap->second;
    apply_joints(body, coordinates.values, pose, posed.anchors.emplace_back());
    posed.bodies.push_back(pose);
    const MjcfMass mass = mass_of(body);
    const glm::dvec3 centre = mass.kilograms > kMinMass ? mass.moment / mass.kilograms : glm::dvec3(0);
    // A given centre counts without mass, too.
    const bool has_centre = body.given_mass && !body.takes_geom_mass;
    posed.masses.push_back(pose * (mass.kilograms > kMinMass || has_centre ? centre : glm::dvec3(0)));
    subtree[i].add(mass.kilograms, posed.masses[i]);
  }
  for (size_t i = count; i-- > 1;) {
    MjcfMass& parent = subtree[*tree.bodies[i].parent];
    parent.kilograms += subtree[i].kilograms;
    parent.moment += subtree[i].moment;
  }
  for (size_t i = 0; i < count; ++i)
    posed.subtree_masses.push_back(subtree[i].kilograms > kMinMass ? subtree[i].moment / subtree[i].kilograms
                                                                   : posed.masses[i]);
  return posed;
}

MjcfExtent extent_of(const MjcfTree& tree, const MjcfPosedBodies& posed) {
  Box box;
  std::vector<double> sizes(tree.bodies.size(), 0);
  for (size_t i = 1; i < tree.bodies.size(); ++i) {
    box.add(posed.bodies[i].position);
    box.add(posed.masses[i]);
    for (const glm::dvec3& anchor : posed.anchors[i]) {
      box.add(anchor);
      for (const size_t body : {i, *tree.bodies[i].parent})
        sizes[body] = std::max(sizes[body], glm::distance(posed.masses[body], anchor));
    }
  }
  for (const MjcfSite& site : tree.sites) box.add(posed.bodies[site.body] * site.pose.position);
  for (const MjcfTreeGeom& each : tree.geoms) {
    const MjcfGeom& geom = each.geom;
    const glm::dvec3 centre = posed.bodies[geom.body] * each.bound_centre;
    double radius = each.bound_radius;
    if (geom.shape == MjcfShape::plane) {
      const double side = std::max(geom.size.x, geom.size.y);
      radius = side > 0 ? 0.1 * side : kInfinitePlaneRadius;
    }
    box.add(centre, radius);
    if (geom.body > 0 && geom.shape != MjcfShape::plane)
      sizes[geom.body] = std::max(sizes[geom.body], radius + glm::distance(posed.masses[geom.body], centre));
  }
  MjcfExtent made;
  made.centre = 0.5 * (box.low + box.high);
  const glm::dvec3 sides = box.high - box.low;
  if (sides.x > 0) made.extent = std::max({1e-5, sides.x, sides.y, sides.z});
  double mean = 0;
  for (size_t i = 1; i < sizes.size(); ++i)
    mean += std::max(sizes[i], 1e-5) / static_cast<double>(sizes.size() - 1);
  made.extent = std::max(made.extent, 2 * mean);
  return made;
}

}  // namespace fire3dv::convert
