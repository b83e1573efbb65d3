// Forward kinematics of an MJCF tree, and what depends on the default pose: centres of mass, extent, cameras
// and lights that track bodies.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "convert/mjcf/bodies/mjcf_tree.h"
#include "convert/mjcf/scene/mjcf_scene.h"

namespace fire3dv::convert {

// Coordinates with all joints at their references.
MjcfCoordinates default_coordinates(const MjcfTree& tree);

struct MjcfPosedBodies {
  std::vector<MjcfPose> bodies;                  // in the world
  std::vector<glm::dvec3> masses;                // centre of mass of each body
  std::vector<glm::dvec3> subtree_masses;        // and of it with all its descendants
  std::vector<std::vector<glm::dvec3>> anchors;  // of each body's joints
};

// coordinates: as many as the tree has.
MjcfPosedBodies pose_bodies(const MjcfTree& tree, const MjcfCoordinates& coordinates);

// Centre and extent of the model in its default pose, as MuJoCo computes them.
struct MjcfExtent {
  glm::dvec3 centre{0};
  double extent = 1;
};
MjcfExtent extent_of(const MjcfTree& tree, const MjcfPosedBodies& posed);

// Fills bodies, cameras and lights of the scene. `rest`: the default pose, which tracking cameras keep their
// offset of.
void pose_scene(const MjcfTree& tree, const MjcfPosedBodies& rest, const MjcfPosedBodies& posed,
                MjcfScene& scene);

}  // namespace fire3dv::convert
