// Kinematic tree of a model: bodies and the joints that move them. The glTF writer stores it as extras of the
// root node; format: docs/joints.md. Frame of a body: that of its node. Units: radians and metres.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fire3dv::convert {

struct Joint {
  enum class Type { fixed, revolute, prismatic, planar, ball, floating };
  struct Mimic {
    size_t joint = 0;  // index into Kinematics::joints
    double multiplier = 1, offset = 0;
  };

  std::string name;  // unique
  Type type = Type::fixed;
  size_t body = 0;                      // index into Kinematics::bodies
  glm::dvec3 anchor{0}, axis{0, 0, 1};  // in the body's frame; the axis has unit length
  std::vector<double> initial;          // position in the scene; positions_of(type) numbers
  // Of revolute and prismatic joints only.
  double reference = 0;  // position at which the body is not displaced
  std::optional<std::pair<double, double>> limits;
  std::optional<Mimic> mimic;
};

struct Body {
  size_t node = 0;  // index into Model::nodes
  // Index into Kinematics::bodies; precedes its children. Empty: the model's frame.
  std::optional<size_t> parent;
  // In the parent, with all joints at their references.
  glm::dvec3 translation{0};
  glm::dquat rotation{1, 0, 0, 0};
};

// Several joints of one body move it one after the other, each in the frame that those before it have moved.
struct Kinematics {
  // A pose that the description names.
  struct NamedPose {
    std::string name;
    std::vector<double> positions;  // of all joints, in their order
  };
  std::vector<Body> bodies;
  std::vector<Joint> joints;  // in the order of positions
  std::vector<NamedPose> poses;

  bool has_joints() const;  // other than fixed ones
};

// Numbers of a position. Floating: x y z, then a unit quaternion x y z w; ball: the quaternion; planar: x, y,
// angle.
size_t positions_of(Joint::Type type);

// "revolute" and so on, as in the file.
const char* name_of(Joint::Type type);

// Removes mimics that lead back to their own joint, and returns the names of those joints.
std::vector<std::string> drop_mimic_loops(std::vector<Joint>& joints);

}  // namespace fire3dv::convert
