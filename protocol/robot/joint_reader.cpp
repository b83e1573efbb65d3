#include "protocol/robot/joint_reader.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "base/text.h"
#include "protocol/robot/rigid.h"

namespace fire3dv::robot {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

std::vector<const char*> endings_of(JointType type) {
  switch (type) {
    case JointType::revolute:
    case JointType::prismatic:
      return {""};
    case JointType::planar:
      return {".x", ".y", ".angle"};
    case JointType::ball:
      return {".qx", ".qy", ".qz", ".qw"};
    case JointType::floating:
      return {".x", ".y", ".z", ".qx", ".qy", ".qz", ".qw"};
    case JointType::fixed:
      break;
  }
  return {};
}

double dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector translation_of(const Transform& t) {
  return {t.m[3], t.m[7], t.m[11]};
}

// Of a rotation about a unit axis, above -pi and at most pi.
double angle_about(const Vector& axis, const Transform& t) {
  const Vector twice_sine{t.m[9] - t.m[6], t.m[2] - t.m[8], t.m[4] - t.m[1]};
  const double twice_cosine = t.m[0] + t.m[5] + t.m[10] - 1;
  return std::atan2(dot(axis, twice_sine), twice_cosine);
}

// The angle plus the number of turns that brings it between the limits, if one does.
double within_limits(double angle, const RobotJoint& joint) {
  constexpr double kRounding = 1e-6;
  if (!joint.has_limits) return angle;
  const double middle = (joint.lower + joint.upper) / 2;
  const double turned = angle + kTurn * std::round((middle - angle) / kTurn);
  const bool is_within = turned >= joint.lower - kRounding && turned <= joint.upper + kRounding;
  return is_within ? turned : angle;
}

// displacement: of the body by this joint alone, as Robot computes it.
void append_position(const RobotJoint& joint, const Transform& displacement, std::vector<double>& positions) {
  const Vector way = translation_of(displacement);
  switch (joint.type) {
    case JointType::revolute: {
      const double angle = std::remainder(angle_about(joint.axis, displacement) + joint.reference, kTurn);
      positions.push_back(within_limits(angle <= -std::numbers::pi ? angle + kTurn : angle, joint));
      return;
    }
    case JointType::prismatic:
      positions.push_back(dot(joint.axis, way) + joint.reference);
      return;
    case JointType::planar: {
      const auto [u, v] = plane_axes(joint.axis);
      positions.insert(positions.end(), {dot(u, way), dot(v, way), angle_about(joint.axis, displacement)});
      return;
    }
    case JointType::floating:
      positions.insert(positions.end(), way.begin(), way.end());
      [[fallthrough]];
    case JointType::ball: {
      const Quaternion q = quaternion_of(displacement);
      positions.insert(positions.end(), q.begin(), q.end());
      return;
    }
    case JointType::fixed:
      return;
  }
}

}  // namespace

std::vector<std::string> position_names(const Robot& robot) {
  std::vector<std::string> names;
  for (const RobotJoint& joint : robot.joints()) {
    if (joint.position_count == 0) continue;
    for (const char* ending : endings_of(joint.type)) names.push_back(joint.name + ending);
  }
  return names;
}

Result<JointReader> JointReader::make(const Robot& robot) {
  JointReader reader(robot);
  for (const RobotBody& body : reader.bodies_) {
    size_t moving = 0;
    for (const size_t joint : body.joints) moving += reader.joints_[joint].type != JointType::fixed;
    if (moving > 1)
      return Error{"the joints of body " + quote(body.node) + " cannot be told apart by its pose"};
  }
  for (size_t i = 0; i < reader.joints_.size(); ++i) {
    if (reader.joints_[i].position_count != 0) reader.read_.push_back(i);
  }
  reader.names_ = position_names(robot);
  return reader;
}

Transform JointReader::rest_pose(size_t body, std::span<const Transform> model_from_body) const {
  const auto& parent = bodies_[body].parent;
  return parent ? model_from_body[*parent] * bodies_[body].parent_from_body : bodies_[body].parent_from_body;
}

void JointReader::read(std::span<const Transform> model_from_body, std::vector<double>& positions) const {
  for (const size_t index : read_) {
    const RobotJoint& joint = joints_[index];
    append_position(joint, inverse(rest_pose(joint.body, model_from_body)) * model_from_body[joint.body],
                    positions);
  }
}

}  // namespace fire3dv::robot
