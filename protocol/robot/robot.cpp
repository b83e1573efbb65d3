#include "protocol/robot/robot.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocol/wire/check.h"

namespace fire3dv::robot {
namespace {

constexpr double kMinQuaternionLength = 1e-9;

std::string in_quotes(const std::string& name) {
  return "\"" + wire::printable(name) + "\"";
}

}  // namespace

std::pair<Vector, Vector> plane_axes(const Vector& normal) {
  const auto [x, y, z] = normal;
  if (z < -1 + 1e-12) return {{1, 0, 0}, {0, -1, 0}};
  const double a = 1 / (1 + z);
  return {{1 - a * x * x, -a * x * y, -x}, {-a * x * y, 1 - a * y * y, -y}};
}

const char* name_of(JointType type) {
  switch (type) {
    case JointType::revolute:
      return "revolute";
    case JointType::prismatic:
      return "prismatic";
    case JointType::planar:
      return "planar";
    case JointType::ball:
      return "ball";
    case JointType::floating:
      return "floating";
    case JointType::fixed:
      break;
  }
  return "fixed";
}

size_t position_count_of(JointType type) {
  switch (type) {
    case JointType::revolute:
    case JointType::prismatic:
      return 1;
    case JointType::planar:
      return 3;
    case JointType::ball:
      return 4;
    case JointType::floating:
      return 7;
    case JointType::fixed:
      break;
  }
  return 0;
}

Result<Robot> Robot::make(std::vector<RobotBody> bodies, std::vector<RobotJoint> joints,
                          const Transform& world_from_model) {
  Robot robot;
  robot.bodies_ = std::move(bodies);
  robot.joints_ = std::move(joints);
  robot.world_from_model_ = world_from_model;
  if (Result<void> done = robot.resolve_leaders(); !done) return done.error();
  for (size_t i = 0; i < robot.joints_.size(); ++i) {
    RobotJoint& joint = robot.joints_[i];
    robot.bodies_[joint.body].joints.push_back(i);
    joint.position_index = robot.positions_.size();
    joint.position_count = joint.leader ? 0 : position_count_of(joint.type);
    if (joint.position_count == 0) continue;
    std::vector<double> initial = joint.initial;
    if (Result<void> done = robot.check(joint, initial, {}); !done) return done.error();
    robot.positions_.insert(robot.positions_.end(), initial.begin(), initial.end());
  }
  robot.find_published();
  return robot;
}

// Bodies with a node in the scene, whose scale a pose would lose.
void Robot::find_published() {
  bool has_scale = false;
  for (size_t i = 0; i < bodies_.size(); ++i) {
    const RobotBody& body = bodies_[i];
    body_index_.emplace(body.node, i);
    if (!body.scale) continue;
    published_.push_back(i);
    node_names_.push_back(body.node);
    has_scale = has_scale || *body.scale != Vector{1, 1, 1};
  }
  if (!has_scale) return;
  for (const size_t body : published_) {
    const auto [x, y, z] = *bodies_[body].scale;
    const auto f = [](double number) { return static_cast<float>(number); };
    body_from_node_.insert(body_from_node_.end(), {f(x), 0, 0, 0, 0, f(y), 0, 0, 0, 0, f(z), 0});
  }
}

// Replaces chains of leaders by their ends.
Result<void> Robot::resolve_leaders() {
  std::vector<bool> is_done(joints_.size()), is_open(joints_.size());
  std::vector<size_t> chain;
  for (size_t start = 0; start < joints_.size(); ++start) {
    size_t at = start;
    for (; !is_done[at] && joints_[at].leader; at = *joints_[at].leader) {
      if (is_open[at])
        return Error{"joint " + in_quotes(joints_[at].name) + " mimics itself, over other joints"};
      is_open[at] = true;
      chain.push_back(at);
    }
    if (!is_done[at]) joints_[at].root = at;
    is_done[at] = true;
    for (; !chain.empty(); chain.pop_back()) {
      RobotJoint& joint = joints_[chain.back()];
      const RobotJoint& leader = joints_[*joint.leader];
      joint.root = leader.root;
      joint.root_multiplier = joint.multiplier * leader.root_multiplier;
      joint.root_offset = joint.multiplier * leader.root_offset + joint.offset;
      is_done[chain.back()] = true;
    }
  }
  return {};
}

// Checks the numbers of one joint, and brings them to their stored form.
Result<void> Robot::check(const RobotJoint& joint, std::span<double> numbers, PositionRules rules) const {
  const auto fault = [&](const std::string& what) {
    return Error{"the position of joint " + in_quotes(joint.name) + " " + what};
  };
  if (numbers.size() != position_count_of(joint.type))
    return fault("has " + std::to_string(numbers.size()) + " numbers; " +
                 std::to_string(position_count_of(joint.type)) + " are needed");
  for (const double number : numbers)
    if (!std::isfinite(number)) return fault("is not finite");
  if (joint.type == JointType::ball || joint.type == JointType::floating) {
    const std::span<double> q = numbers.last(4);
    if (rules.is_wxyz) std::rotate(q.begin(), q.begin() + 1, q.end());
    const double size = length(Quaternion{q[0], q[1], q[2], q[3]});
    if (!(size > kMinQuaternionLength) || !std::isfinite(size))
      return fault("has a quaternion without length; a unit quaternion is needed");
    for (double& number : q) number /= size;
  }
  if (rules.clamps && joint.has_limits) numbers[0] = std::clamp(numbers[0], joint.lower, joint.upper);
  return {};
}

Result<void> Robot::set_joint(size_t index, std::span<const double> positions, PositionRules rules) {
  const RobotJoint& joint = joints_[index];
  if (joint.leader)
    return Error{"joint " + in_quotes(joint.name) + " follows " + in_quotes(joints_[joint.root].name) +
                 ": set that one, or open the robot without mimic"};
  if (joint.position_count == 0)
    return Error{"joint " + in_quotes(joint.name) + " is fixed; it has no position"};
  std::vector<double> numbers(positions.begin(), positions.end());
  if (Result<void> done = check(joint, numbers, rules); !done) return done;
  std::copy(numbers.begin(), numbers.end(),
            positions_.begin() + static_cast<std::ptrdiff_t>(joint.position_index));
  is_posed_ = false;
  return {};
}

// Checks the numbers of all joints, and brings them to their stored form.
Result<void> Robot::check_all(std::span<double> numbers, PositionRules rules) const {
  if (numbers.size() != positions_.size())
    return Error{"there are " + std::to_string(numbers.size()) + " positions; the robot has " +
                 std::to_string(positions_.size())};
  for (const RobotJoint& joint : joints_) {
    if (joint.position_count == 0) continue;
    const std::span<double> own = numbers.subspan(joint.position_index, joint.position_count);
    if (Result<void> done = check(joint, own, rules); !done) return done;
  }
  return {};
}

Result<void> Robot::set_positions(std::span<const double> positions, PositionRules rules) {
  std::vector<double> numbers(positions.begin(), positions.end());
  if (Result<void> done = check_all(numbers, rules); !done) return done;
  positions_ = std::move(numbers);
  is_posed_ = false;
  return {};
}

Result<void> Robot::add_named_pose(NamedPose pose) {
  if (Result<void> done = check_all(pose.positions, {}); !done)
    return Error{"pose " + in_quotes(pose.name) + ": " + done.error().message};
  named_poses_.push_back(std::move(pose));
  return {};
}

void Robot::set_base(const Transform& stream_from_model) {
  stream_from_model_ = stream_from_model;
  is_posed_ = false;
}

// body_from_body: right-multiplied, in the frame that the joints before have moved.
Transform Robot::displacement(const RobotJoint& joint) const {
  const double* const q = &positions_[joints_[joint.root].position_index];
  const auto about_anchor = [&](const Transform& turn) {
    const auto [x, y, z] = joint.anchor;
    return translation(joint.anchor) * turn * translation({-x, -y, -z});
  };
  const auto [x, y, z] = joint.axis;
  switch (joint.type) {
    case JointType::revolute:
      return about_anchor(
          rotation(joint.axis, joint.root_multiplier * q[0] + joint.root_offset - joint.reference));
    case JointType::prismatic: {
      const double way = joint.root_multiplier * q[0] + joint.root_offset - joint.reference;
      return translation({x * way, y * way, z * way});
    }
    case JointType::planar: {
      const auto [u, v] = plane_axes(joint.axis);
      Vector way;
      for (size_t i = 0; i < 3; ++i) way[i] = u[i] * q[0] + v[i] * q[1];
      return translation(way) * rotation(joint.axis, q[2]);
    }
    case JointType::ball:
      return about_anchor(rotation(Quaternion{q[0], q[1], q[2], q[3]}));
    case JointType::floating:
      return translation({q[0], q[1], q[2]}) * rotation(Quaternion{q[3], q[4], q[5], q[6]});
    case JointType::fixed:
      break;
  }
  return {};
}

const std::vector<Transform>& Robot::poses() {
  if (std::exchange(is_posed_, true)) return poses_;
  poses_.resize(bodies_.size());
  for (size_t i = 0; i < bodies_.size(); ++i) {
    const RobotBody& body = bodies_[i];
    poses_[i] = (body.parent ? poses_[*body.parent] : stream_from_model_) * body.parent_from_body;
    for (const size_t joint : body.joints)
      if (joints_[joint].type != JointType::fixed) poses_[i] = poses_[i] * displacement(joints_[joint]);
  }
  return poses_;
}

void Robot::write_poses(std::span<float> stream_from_node) {
  const std::vector<Transform>& all = poses();
  for (size_t i = 0; i < published_.size(); ++i)
    for (size_t k = 0; k < 12; ++k)
      stream_from_node[12 * i + k] = static_cast<float>(all[published_[i]].m[k]);
}

std::optional<size_t> Robot::body_called(std::string_view node) const {
  const auto found = body_index_.find(node);
  if (found == body_index_.end()) return std::nullopt;
  return found->second;
}

}  // namespace fire3dv::robot
