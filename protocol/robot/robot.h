// Robot: kinematic tree of a scene file with its current positions, and forward kinematics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fire3dv/joints.h"
#include "protocol/base/error.h"
#include "rigid.h"

namespace fire3dv::client {

struct RobotJoint {
  std::string name;
  size_t body = 0;
  int32_t type = FIRE3DV_JOINT_FIXED;
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

// Numbers of a position of a FIRE3DV_JOINT_* type.
size_t position_count_of(int32_t type);

class Robot {
 public:
  // The error names the joints that follow each other in a loop.
  static Result<Robot> make(std::vector<RobotBody> bodies, std::vector<RobotJoint> joints,
                            const Transform& world_from_model);

  const std::vector<RobotBody>& bodies() const { return bodies_; }
  const std::vector<RobotJoint>& joints() const { return joints_; }
  const std::vector<double>& positions() const { return positions_; }

  // Sets `count` numbers from `first` on. flags: FIRE3DV_POSITIONS_*. On error nothing changes.
  Result<void> set_joint(size_t joint, std::span<const double> positions, uint32_t flags);
  Result<void> set_positions(std::span<const double> positions, uint32_t flags);
  void set_base(const Transform& stream_from_model);

  // Node names and scales as pointers into this object.
  void describe(fire3dv_description& description) const;
  size_t published_count() const { return published_.size(); }

  // stream_from_body of all bodies. Computed when positions or base have changed.
  const std::vector<Transform>& poses();
  // Poses of the described nodes; the span has 12 numbers for each.
  void write_poses(std::span<float> stream_from_node);
  std::optional<size_t> body_called(std::string_view node) const;

 private:
  Result<void> check(const RobotJoint& joint, std::span<double> numbers, uint32_t flags) const;
  Transform displacement(const RobotJoint& joint) const;
  Result<void> resolve_leaders();
  void find_published();

  std::vector<RobotBody> bodies_;
  std::vector<RobotJoint> joints_;
  std::vector<double> positions_;
  std::map<std::string, size_t, std::less<>> body_index_;
  std::vector<size_t> published_;  // bodies with a scene node
  std::vector<std::string> node_names_;
  std::vector<const char*> node_name_pointers_;
  std::vector<float> body_from_node_;  // empty: no scales
  Transform world_from_model_, stream_from_model_;
  std::vector<Transform> poses_;
  bool is_posed_ = false;
};

}  // namespace fire3dv::client

struct fire3dv_robot {
  fire3dv::client::Robot robot;
  std::vector<float> published;  // poses of the last frame
};
