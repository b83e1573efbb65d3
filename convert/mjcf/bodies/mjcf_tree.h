// Kinematic tree of an MJCF model before it is posed: bodies with joints, and objects in the frames of their
// bodies.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "convert/mjcf/scene/mjcf_scene.h"

namespace fire3dv::convert {

struct MjcfJoint {
  enum class Type { free, ball, slide, hinge };
  Type type = Type::hinge;
  std::string name;                       // empty: none
  glm::dvec3 position{0}, axis{0, 0, 1};  // in the body; the axis has unit length
  double reference = 0;                   // coordinate in the default pose; radians or metres
  size_t first_coordinate = 0;            // index into the model's coordinates (qpos)
  std::optional<glm::dvec2> range;        // slide, hinge: limits; radians or metres
};

inline size_t coordinates_of(MjcfJoint::Type type) {
  return type == MjcfJoint::Type::free ? 7 : type == MjcfJoint::Type::ball ? 4 : 1;
}

struct MjcfMass {
  double kilograms = 0;
  glm::dvec3 moment{0};  // sum of mass times position, in the body

  void add(double mass, const glm::dvec3& position) {
    kilograms += mass;
    moment += mass * position;
  }
};

struct MjcfTreeBody {
  std::string name;
  std::optional<size_t> parent;
  MjcfPose pose;  // in the parent, with all joints at their references
  bool is_mocap = false;
  std::vector<MjcfJoint> joints;
  std::optional<MjcfMass> given_mass;  // of an inertial element
  MjcfMass geom_mass;
  bool takes_geom_mass = false;  // even with an inertial element
};

struct MjcfTreeGeom {
  MjcfGeom geom;
  double bound_radius = 0;     // bounding sphere; 0: plane
  glm::dvec3 bound_centre{0};  // in the body
};

struct MjcfSite {
  size_t body = 0;
  MjcfPose pose;  // in the body
};

// Skin that belongs to generated bodies; vertices in the frame of their parent.
struct MjcfTreeSkin {
  MjcfSkin skin;
  double inflation = 0;
};

// Modes of cameras and lights that follow a body with their position, or turn to another.
enum class MjcfTracking { fixed, track, track_mass, target_body, target_mass };

struct MjcfTracked {
  MjcfTracking mode = MjcfTracking::fixed;
  std::string target, target_in_scope;  // name as in the file, and with the prefix and suffix of its copy
};

class MjcfSource;

// Copy of a part of a model, by an attachment or a replica. Tendons over it are copied, too.
struct MjcfCopy {
  MjcfSource* source = nullptr;
  std::string prefix, suffix;  // of names
};

struct MjcfTree {
  std::vector<MjcfTreeBody> bodies;  // the world first
  std::vector<MjcfTreeGeom> geoms;   // by body once the tree is complete
  std::vector<MjcfCamera> cameras;   // world_pose: in the body
  std::vector<MjcfTracked> camera_tracking;
  std::vector<MjcfLight> lights;  // position, direction: in the body
  std::vector<MjcfTracked> light_tracking;
  std::vector<MjcfSite> sites;
  std::vector<MjcfTreeSkin> skins;  // of flexcomps and composites
  size_t coordinates = 0;
  std::vector<MjcfCopy> copies;  // at most 10,000; the model itself is the first
  // Indices by name; the first object of a name counts.
  std::map<std::string, size_t, std::less<>> body_index, site_index, geom_index;
};

// Pose of a tree: one number per coordinate, and poses of motion-capture bodies.
struct MjcfCoordinates {
  std::vector<double> values;
  std::map<size_t, MjcfPose> mocap;  // by body, in the world
};

}  // namespace fire3dv::convert
