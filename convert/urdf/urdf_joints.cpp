#include "convert/urdf/urdf_joints.h"

#include <urdf_model/joint.h>
#include <urdf_model/link.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/text.h"

namespace fire3dv::convert {
namespace {

glm::dvec3 joint_vec3(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}

bool is_scalar(const urdf::Joint& joint) {
  return joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS ||
         joint.type == urdf::Joint::PRISMATIC;
}

Joint::Type type_of(const urdf::Joint& joint) {
  switch (joint.type) {
    case urdf::Joint::REVOLUTE:
    case urdf::Joint::CONTINUOUS:
      return Joint::Type::revolute;
    case urdf::Joint::PRISMATIC:
      return Joint::Type::prismatic;
    case urdf::Joint::PLANAR:
      return Joint::Type::planar;
    case urdf::Joint::FLOATING:
      return Joint::Type::floating;
    default:
      return Joint::Type::fixed;
  }
}

// Position at which a revolute or prismatic joint rests without the one that it mimics: 0, or the nearest
// limit.
double rest_position(const urdf::Joint& joint) {
  const bool has_axis = glm::length(joint_vec3(joint.axis)) > 0;
  const bool limited = joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::PRISMATIC;
  if (!limited || !has_axis || !joint.limits || !(joint.limits->lower <= joint.limits->upper)) return 0;
  return std::clamp(0.0, joint.limits->lower, joint.limits->upper);
}

std::vector<double> initial_of(const urdf::Joint& joint) {
  if (joint.type == urdf::Joint::PLANAR) return {0, 0, 0};
  if (joint.type == urdf::Joint::FLOATING) return {0, 0, 0, 0, 0, 0, 1};
  if (is_scalar(joint)) return {rest_position(joint)};
  return {};
}

// A missing <limit> is read as 0 to 0, and is no limit.
std::optional<std::pair<double, double>> limits_of(const urdf::Joint& joint) {
  if (joint.type != urdf::Joint::REVOLUTE && joint.type != urdf::Joint::PRISMATIC) return std::nullopt;
  if (!joint.limits || !(joint.limits->lower < joint.limits->upper)) return std::nullopt;
  if (!std::isfinite(joint.limits->lower) || !std::isfinite(joint.limits->upper)) return std::nullopt;
  return std::pair(joint.limits->lower, joint.limits->upper);
}

Joint joint_of(const urdf::Joint& from, size_t body, std::vector<std::string>& warnings) {
  Joint made;
  made.name = from.name;
  made.body = body;
  made.type = type_of(from);
  const double length = glm::length(joint_vec3(from.axis));
  const bool needs_axis = is_scalar(from) || made.type == Joint::Type::planar;
  if (needs_axis && !(length > 0)) {
    warnings.push_back("joint " + quote(from.name) + " has an axis without length; it is fixed");
    made.type = Joint::Type::fixed;
    return made;
  }
  if (needs_axis) made.axis = joint_vec3(from.axis) / length;
  made.limits = limits_of(from);
  made.initial = initial_of(from);
  return made;
}

// Joints that mimic others rest where these put them. The mimics have no loops.
void apply_mimics(std::vector<Joint>& joints) {
  std::vector<bool> is_done(joints.size());
  std::vector<size_t> chain;
  for (size_t start = 0; start < joints.size(); ++start) {
    for (size_t at = start; joints[at].mimic && !is_done[at]; at = joints[at].mimic->joint)
      chain.push_back(at);
    for (; !chain.empty(); chain.pop_back()) {
      Joint& joint = joints[chain.back()];
      joint.initial = {joint.mimic->multiplier * joints[joint.mimic->joint].initial[0] + joint.mimic->offset};
      is_done[chain.back()] = true;
    }
  }
}

// Moves the node of the joint's body, which is at the joint's origin, to where the joint rests.
void move_to_rest(const Joint& joint, Node& node) {
  if (joint.type == Joint::Type::revolute) node.rotation *= glm::angleAxis(joint.initial[0], joint.axis);
  if (joint.type == Joint::Type::prismatic)
    node.translation += node.rotation * (joint.axis * joint.initial[0]);
}

}  // namespace

void add_urdf_joints(const urdf::ModelInterface& robot, const std::vector<std::string>& joint_names,
                     const std::map<std::string, size_t>& node_of_link, Model& model,
                     std::vector<std::string>& warnings) {
  Kinematics& made = model.kinematics;
  std::map<size_t, size_t> body_of_node;
  for (size_t node = 0; node < model.nodes.size(); ++node) {
    const auto link = robot.links_.find(model.nodes[node].name);
    if (link == robot.links_.end()) continue;
    Body body;
    body.node = node;
    if (model.nodes[node].parent) body.parent = body_of_node.at(*model.nodes[node].parent);
    if (const urdf::JointSharedPtr& joint = link->second->parent_joint) {
      const urdf::Pose& origin = joint->parent_to_joint_origin_transform;
      body.translation = joint_vec3(origin.position);
      body.rotation = {origin.rotation.w, origin.rotation.x, origin.rotation.y, origin.rotation.z};
    }
    body_of_node[node] = made.bodies.size();
    made.bodies.push_back(body);
  }
  std::map<std::string, size_t> index_of;
  for (const std::string& name : joint_names) {
    const auto joint = robot.joints_.find(name);
    if (joint == robot.joints_.end()) continue;
    const auto node = node_of_link.find(joint->second->child_link_name);
    if (node == node_of_link.end() || !index_of.emplace(name, made.joints.size()).second) continue;
    made.joints.push_back(joint_of(*joint->second, body_of_node.at(node->second), warnings));
  }
  for (const auto& [name, index] : index_of) {
    const urdf::JointMimicSharedPtr& mimic = robot.joints_.at(name)->mimic;
    if (!mimic || made.joints[index].type == Joint::Type::fixed) continue;
    const auto leader = index_of.find(mimic->joint_name);
    if (leader == index_of.end() || made.joints[leader->second].initial.size() != 1 ||
        made.joints[index].initial.size() != 1) {
      warnings.push_back("joint " + quote(name) + " mimics " + quote(mimic->joint_name) +
                         ", which is not a revolute or prismatic joint of the robot; it moves by itself");
      continue;
    }
    made.joints[index].mimic = Joint::Mimic{leader->second, mimic->multiplier, mimic->offset};
  }
  for (const std::string& name : drop_mimic_loops(made.joints))
    warnings.push_back("joint " + quote(name) + " mimics itself, over others; it moves by itself");
  apply_mimics(made.joints);
  for (const Joint& joint : made.joints) move_to_rest(joint, model.nodes[made.bodies[joint.body].node]);
}

}  // namespace fire3dv::convert
