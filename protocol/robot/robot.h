// Robot: kinematic tree of a scene file with its current positions, and forward kinematics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "protocol/robot/rigid.h"

namespace fire3dv::robot {

enum class JointType : int32_t { fixed, revolute, prismatic, planar, ball, floating };
const char* name_of(JointType type);  // one lowercase word, as in files

// How positions are given.
struct PositionRules {
  bool clamps = false;   // to the limits; without it, positions beyond the limits are valid
  bool is_wxyz = false;  // quaternions are w x y z instead of x y z w
};

struct RobotJoint {
  std::string name;
  size_t body = 0;
  JointType type = JointType::fixed;
  Vector axis{0, 0, 1}, anchor{0, 0, 0};  // in the body's frame; the axis has unit length
  double reference = 0;                   // position at which the body is not displaced
  bool has_limits = false;
  double lower = 0, upper = 0;
  std::optional<size_t> leader;  // joint that this one follows
  double multiplier = 1, offset = 0;
  std::vector<double> initial;

  // Set by Robot: the end of the chain of leaders, and position = root_multiplier * its position +
  // root_offset.
  size_t root = 0;
  double root_multiplier = 1, root_offset = 0;
  size_t position_index = 0, position_count = 0;
};

struct RobotBody {
  std::string node;
  std::optional<size_t> parent;  // precedes its children
  Transform parent_from_body;    // with all joints at their references
  std::vector<size_t> joints;    // in the order in which they move it
  std::optional<Vector> scale;   // of its scene node; empty: the scene has no such node
};

// A pose that the description names, such as a keyframe of MJCF.
struct NamedPose {
  std::string name;
  std::vector<double> positions;  // as of Robot::positions()
};

// Count of the numbers of a position.
size_t position_count_of(JointType type);
// Axes of a planar joint: X and Y turned by the shortest rotation from Z to the normal.
std::pair<Vector, Vector> plane_axes(const Vector& normal);

class Robot {
 public:
  // The error names the joints that follow each other in a loop.
  static Result<Robot> make(std::vector<RobotBody> bodies, std::vector<RobotJoint> joints,
                            const Transform& world_from_model);

  const std::vector<RobotBody>& bodies() const { return bodies_; }
  const std::vector<RobotJoint>& joints() const { return joints_; }
  const std::vector<double>& positions() const { return positions_; }
  const std::vector<NamedPose>& named_poses() const { return named_poses_; }

  // Fails for positions that are not those of a pose.
  Result<void> add_named_pose(NamedPose pose);
  // On error nothing changes.
  Result<void> set_joint(size_t joint, std::span<const double> positions, PositionRules rules = {});
  Result<void> set_positions(std::span<const double> positions, PositionRules rules = {});
  void set_base(const Transform& stream_from_model);

  // Bodies with a scene node: the node's name and, unless all are 1, its scale as 3x4 matrices, row-major.
  const std::vector<std::string>& node_names() const { return node_names_; }
  const std::vector<float>& body_from_node() const { return body_from_node_; }
  const Transform& world_from_model() const { return world_from_model_; }

  // stream_from_body of all bodies. Computed when positions or base have changed.
  const std::vector<Transform>& poses();
  // Poses of the nodes of node_names(); the span has 12 numbers for each.
  void write_poses(std::span<float> stream_from_node);
  std::optional<size_t> body_called(std::string_view node) const;

 private:
  Result<void> check_all(std::span<double> numbers, PositionRules rules) const;
  Result<void> check(const RobotJoint& joint, std::span<double> numbers, PositionRules rules) const;
  Transform displacement(const RobotJoint& joint) const;
  Result<void> resolve_leaders();
  void find_published();

  std::vector<RobotBody> bodies_;
  std::vector<RobotJoint> joints_;
  std::vector<double> positions_;
  std::vector<NamedPose> named_poses_;
  std::map<std::string, size_t, std::less<>> body_index_;
  std::vector<size_t> published_;  // bodies with a scene node
  std::vector<std::string> node_names_;
  std::vector<float> body_from_node_;  // empty: no scales
  Transform world_from_model_, stream_from_model_;
  std::vector<Transform> poses_;
  bool is_posed_ = false;
};

}  // namespace fire3dv::robot
