#include "convert/adf/adf_joints.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

#include "convert/model.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

std::optional<Joint::Type> type_of(const std::string& name) {
  static const std::pair<const char*, Joint::Type> kTypes[] = {
      {"hinge", Joint::Type::revolute},          {"revolute", Joint::Type::revolute},
      {"continuous", Joint::Type::revolute},     {"slider", Joint::Type::prismatic},
      {"prismatic", Joint::Type::prismatic},     {"fixed", Joint::Type::fixed},
      {"spring", Joint::Type::prismatic},        {"linear spring", Joint::Type::prismatic},
      {"torsion spring", Joint::Type::revolute}, {"torsional spring", Joint::Type::revolute},
      {"angular spring", Joint::Type::revolute}, {"p2p", Joint::Type::ball},
      {"cone twist", Joint::Type::ball},         {"six dof", Joint::Type::floating},
      {"six dof spring", Joint::Type::floating}};
  for (const auto& [known, type] : kTypes)
    if (name == known) return type;
  return std::nullopt;
}

// Rotation from one unit vector to another, by AMBF's rules: opposite vectors turn about an axis normal to X,
// or to Y.
glm::dquat rotation_between(const glm::dvec3& from, const glm::dvec3& to) {
  const double angle = std::acos(std::clamp(glm::dot(from, to), -1.0, 1.0));
  if (angle < 0.001) return glm::angleAxis(angle, glm::dvec3(0, 0, 1));
  if (angle <= 3.14) return glm::angleAxis(angle, glm::normalize(glm::cross(from, to)));
  const double from_x = std::acos(std::clamp(from.x, -1.0, 1.0));
  const bool is_off_x = from_x > 0.001 && from_x < 3.14;
  const glm::dvec3 axis =
      is_off_x ? glm::cross(from, glm::dvec3(1, 0, 0)) : glm::cross(to, glm::dvec3(0, 1, 0));
  return glm::angleAxis(angle, glm::normalize(axis));
}

double signed_angle(const glm::dquat& turn, const glm::dvec3& axis) {
  return std::remainder(2 * std::atan2(glm::dot(glm::dvec3(turn.x, turn.y, turn.z), axis), turn.w),
                        2 * std::numbers::pi);
}

class KinematicsBuilder {
 public:
  KinematicsBuilder(const std::vector<AdfJoint>& joints, const std::vector<AdfJointBody>& bodies,
                    AdfReport& report)
      : joints_(joints), bodies_(bodies), report_(report) {
    for (size_t i = 0; i < bodies.size(); ++i) {
      by_id_.emplace(std::pair(bodies[i].file, bodies[i].id), i);
      by_name_.emplace(bodies[i].name, i);
    }
  }

  Kinematics build() {
    joint_of_.assign(bodies_.size(), std::nullopt);
    parent_of_.assign(bodies_.size(), std::nullopt);
    std::set<size_t> used;
    for (size_t i = 0; i < joints_.size(); ++i) connect(i, used);
    body_of_.assign(bodies_.size(), std::nullopt);
    for (const size_t body : used) add_body(body);
    for (size_t i = 0; i < joints_.size(); ++i)
      if (child_of_.contains(i)) add_joint(i);
    return std::move(made_);
  }

 private:
  std::optional<size_t> body_called(const AdfJoint& joint, const std::string& name) const {
    if (const auto own = by_id_.find({joint.file, name}); own != by_id_.end()) return own->second;
    if (const auto any = by_name_.find(name); any != by_name_.end()) return any->second;
    return std::nullopt;
  }

  void connect(size_t index, std::set<size_t>& used) {
    const AdfJoint& joint = joints_[index];
    const std::string left_out = joint.location + ": joint " + quote(joint.name) + " is left out: ";
    const std::optional<size_t> parent = body_called(joint, joint.parent),
                                child = body_called(joint, joint.child);
    const bool is_world = joint.parent == "world" || joint.parent == "World" || joint.parent == "WORLD";
    if (!child || (!parent && !is_world))
      return report_.warn(left_out + "there is no body " + quote(child ? joint.parent : joint.child));
    if (joint_of_[*child])
      return report_.warn(left_out + quote(joint.child) +
                          " hangs on another joint already, and poses cannot close a loop");
    size_t steps = 0;
    for (std::optional<size_t> at = parent; at; at = parent_of_[*at])
      if (*at == *child || ++steps > kMaxDepth)
        return report_.warn(left_out +
                            (*at == *child ? "its bodies form a loop" : "its bodies form too long a chain"));
    joint_of_[*child] = index;
    parent_of_[*child] = parent;
    child_of_[index] = *child;
    used.insert(*child);
    if (parent) used.insert(*parent);
  }

  // Adds those above first.
  void add_body(size_t index) {
    std::vector<size_t> above;
    for (std::optional<size_t> at = index; at && !body_of_[*at]; at = parent_of_[*at]) above.push_back(*at);
    for (; !above.empty(); above.pop_back()) {
      const size_t body = above.back();
      Body made;
      made.node = bodies_[body].node;
      if (parent_of_[body]) made.parent = body_of_[*parent_of_[body]];
      if (joint_of_[body]) {
        std::tie(made.translation, made.rotation) = transform_of(joints_[*joint_of_[body]], body);
      } else {
        made.translation = bodies_[body].translation;
        made.rotation = bodies_[body].rotation;
      }
      body_of_[body] = made_.bodies.size();
      made_.bodies.push_back(made);
    }
  }

  double parent_scale(size_t child) const {
    return parent_of_[child] ? bodies_[*parent_of_[child]].scale : 1;
  }

  // Of the child in its parent, where the position of the joint is 0.
  std::pair<glm::dvec3, glm::dquat> transform_of(const AdfJoint& joint, size_t child) const {
    if (joint.type == Joint::Type::floating) return {glm::dvec3(0), glm::dquat(1, 0, 0, 0)};
    glm::dquat turn(1, 0, 0, 0);
    if (joint.type != Joint::Type::ball)
      turn = glm::angleAxis(joint.offset_rad, joint.parent_axis) *
             rotation_between(joint.child_axis, joint.parent_axis);
    return {joint.parent_pivot * parent_scale(child) - turn * (joint.child_pivot * bodies_[child].scale),
            turn};
  }

  void add_joint(size_t index) {
    const AdfJoint& from = joints_[index];
    const size_t child = child_of_.at(index);
    Joint made;
    made.name = from.name;
    for (int i = 1; !names_.insert(made.name).second; ++i) made.name = from.name + std::to_string(i);
    made.type = from.type;
    made.body = body_of_[child].value();
    made.axis = from.child_axis;
    if (from.type == Joint::Type::revolute || from.type == Joint::Type::ball)
      made.anchor = from.child_pivot * bodies_[child].scale;
    if (from.type == Joint::Type::revolute || from.type == Joint::Type::prismatic) made.limits = from.limits;
    made.initial = initial_of(from, child);
    made_.joints.push_back(std::move(made));
  }

  // Position at which the bodies are placed as the file says.
  std::vector<double> initial_of(const AdfJoint& joint, size_t child) const {
    const glm::dvec3 origin = parent_of_[child] ? bodies_[*parent_of_[child]].translation : glm::dvec3(0);
    const glm::dquat turned =
        parent_of_[child] ? bodies_[*parent_of_[child]].rotation : glm::dquat(1, 0, 0, 0);
    const glm::dvec3 at = glm::conjugate(turned) * (bodies_[child].translation - origin);
    const glm::dquat turn = glm::normalize(glm::conjugate(turned) * bodies_[child].rotation);
    const auto [zero_at, zero_turn] = transform_of(joint, child);
    switch (joint.type) {
      case Joint::Type::revolute:
        return {signed_angle(glm::conjugate(zero_turn) * turn, joint.child_axis)};
      case Joint::Type::prismatic:
        return {glm::dot(at - zero_at, joint.parent_axis)};
      case Joint::Type::ball:
        return {turn.x, turn.y, turn.z, turn.w};
      case Joint::Type::floating:
        return {at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w};
      default:
        return {};
    }
  }

  static constexpr size_t kMaxDepth = 1000;

  const std::vector<AdfJoint>& joints_;
  const std::vector<AdfJointBody>& bodies_;
  AdfReport& report_;
  std::map<std::pair<size_t, std::string>, size_t> by_id_;
  std::map<std::string, size_t> by_name_;
  std::vector<std::optional<size_t>> joint_of_, parent_of_, body_of_;  // by body
  std::map<size_t, size_t> child_of_;                                  // by joint
  std::set<std::string> names_;
  Kinematics made_;
};

}  // namespace

std::optional<AdfJoint> read_adf_joint(const AdfFile::Block& block, size_t file) {
  const AdfValue& b = block.value;
  AdfJoint joint;
  joint.name = sanitize_text(b["name"].text(block.id));
  joint.parent = b["parent"].text();
  joint.child = b["child"].text();
  joint.location = b.location();
  joint.file = file;
  const std::string type = b["type"].text();
  if (const std::optional<Joint::Type> known = type_of(type)) {
    joint.type = *known;
  } else {
    b.warn("is a joint of the unknown type " + quote(type) + "; it is left out");
    return std::nullopt;
  }
  joint.parent_pivot = b["parent pivot"].vector(glm::dvec3(0));
  joint.child_pivot = b["child pivot"].vector(glm::dvec3(0));
  joint.offset_rad = b["offset"].is_defined() ? b["offset"].number(0) : b["child offset"].number(0);
  const AdfValue low = b["joint limits"]["low"], high = b["joint limits"]["high"];
  if (low.is_defined() && high.is_defined() && low.number(0) <= high.number(0))
    joint.limits = std::pair(low.number(0), high.number(0));
  if (joint.type == Joint::Type::ball || joint.type == Joint::Type::floating) return joint;
  joint.parent_axis = b["parent axis"].vector(glm::dvec3(0, 0, 1));
  joint.child_axis = b["child axis"].vector(glm::dvec3(0, 0, 1));
  for (glm::dvec3* axis : {&joint.parent_axis, &joint.child_axis}) {
    if (!(glm::length(*axis) > 1e-9)) {
      b.warn("is a joint with an axis without length; it is left out");
      return std::nullopt;
    }
    *axis = glm::normalize(*axis);
  }
  return joint;
}

Kinematics adf_kinematics(const std::vector<AdfJoint>& joints, const std::vector<AdfJointBody>& bodies,
                          AdfReport& report) {
  return KinematicsBuilder(joints, bodies, report).build();
}

}  // namespace fire3dv::convert
