#include "convert/glb/glb_joints.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>

#include "convert/model.h"

namespace fire3dv::convert {
namespace {

using tinygltf::Value;

constexpr int kVersion = 1;
constexpr size_t kMaxBodies = 100'000;  // limit of readers; docs/joints.md

Value list(std::initializer_list<double> numbers) {
  Value::Array array;
  for (const double number : numbers) array.emplace_back(number);
  return Value(std::move(array));
}

Value list(const glm::dvec3& v) {
  return list({v.x, v.y, v.z});
}

std::string clean(const std::string& name) {
  return sanitize_text(name, name.size());
}

bool is_finite(const Body& body) {
  return std::isfinite(glm::dot(body.translation, body.translation) + glm::dot(body.rotation, body.rotation));
}

bool is_finite(const Joint& joint) {
  double sum = glm::dot(joint.anchor, joint.anchor) + glm::dot(joint.axis, joint.axis) + joint.reference;
  for (const double number : joint.initial) sum += number;
  if (joint.mimic) sum += joint.mimic->multiplier + joint.mimic->offset;
  return std::isfinite(sum);
}

Value body_value(const Kinematics& kinematics, size_t index, const std::vector<std::string>& node_names) {
  const Body& body = kinematics.bodies[index];
  Value::Object members;
  members["node"] = Value(node_names[body.node]);
  if (body.parent) members["parent"] = Value(node_names[kinematics.bodies[*body.parent].node]);
  if (body.translation != glm::dvec3(0)) members["translation"] = list(body.translation);
  const glm::dquat unit = glm::normalize(body.rotation);
  if (unit != glm::dquat(1, 0, 0, 0)) members["rotation"] = list({unit.x, unit.y, unit.z, unit.w});
  return Value(std::move(members));
}

Value joint_value(const Kinematics& kinematics, size_t index, const std::vector<std::string>& node_names) {
  const Joint& joint = kinematics.joints[index];
  Value::Object members;
  members["name"] = Value(clean(joint.name));
  members["type"] = Value(std::string(name_of(joint.type)));
  members["node"] = Value(node_names[kinematics.bodies[joint.body].node]);
  const bool has_axis = joint.type == Joint::Type::revolute || joint.type == Joint::Type::prismatic ||
                        joint.type == Joint::Type::planar;
  if (has_axis) members["axis"] = list(glm::normalize(joint.axis));
  if (joint.anchor != glm::dvec3(0)) members["anchor"] = list(joint.anchor);
  if (joint.reference != 0) members["reference"] = Value(joint.reference);
  if (joint.limits) members["limits"] = list({joint.limits->first, joint.limits->second});
  if (joint.mimic) {
    Value::Object mimic;
    mimic["joint"] = Value(clean(kinematics.joints[joint.mimic->joint].name));
    mimic["multiplier"] = Value(joint.mimic->multiplier);
    mimic["offset"] = Value(joint.mimic->offset);
    members["mimic"] = Value(std::move(mimic));
  }
  if (!joint.initial.empty()) {
    Value::Array initial;
    for (const double number : joint.initial) initial.emplace_back(number);
    members["initial"] = Value(std::move(initial));
  }
  return Value(std::move(members));
}

// Why the joints cannot be written, or "".
std::string fault_of(const Kinematics& kinematics, const std::vector<std::string>& node_names) {
  if (kinematics.bodies.size() > kMaxBodies || kinematics.joints.size() > kMaxBodies)
    return "there are more than " + std::to_string(kMaxBodies) + " bodies or joints";
  std::set<std::string> names;
  for (const Body& body : kinematics.bodies) {
    if (!names.insert(node_names[body.node]).second)
      return "two bodies are called \"" + node_names[body.node] + "\"";
    if (!is_finite(body)) return "the transform of \"" + node_names[body.node] + "\" is not finite";
  }
  names.clear();
  for (const Joint& joint : kinematics.joints) {
    if (!names.insert(clean(joint.name)).second) return "two joints are called \"" + clean(joint.name) + "\"";
    if (!is_finite(joint)) return "the joint \"" + clean(joint.name) + "\" is not made of finite numbers";
  }
  return "";
}

std::string text_of(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", number);
  return text;
}

}  // namespace

std::optional<Value> joint_extras(const Kinematics& kinematics, const std::vector<std::string>& node_names,
                                  std::vector<std::string>& warnings) {
  if (!kinematics.has_joints()) return std::nullopt;
  if (const std::string fault = fault_of(kinematics, node_names); !fault.empty()) {
    warnings.push_back("the joints are left out, so that the scene moves by poses only: " + fault);
    return std::nullopt;
  }
  Value::Array bodies, joints;
  for (size_t i = 0; i < kinematics.bodies.size(); ++i)
    bodies.push_back(body_value(kinematics, i, node_names));
  for (size_t i = 0; i < kinematics.joints.size(); ++i)
    joints.push_back(joint_value(kinematics, i, node_names));
  size_t count = 0;
  for (const Joint& joint : kinematics.joints) count += positions_of(joint.type);
  Value::Array poses;
  for (const Kinematics::NamedPose& pose : kinematics.poses) {
    Value::Array positions;
    for (const double number : pose.positions) positions.emplace_back(number);
    const bool is_whole =
        positions.size() == count && std::all_of(pose.positions.begin(), pose.positions.end(),
                                                 [](double number) { return std::isfinite(number); });
    if (!is_whole)
      warnings.push_back("the pose \"" + clean(pose.name) + "\" is left out: its positions are invalid");
    if (is_whole)
      poses.emplace_back(
          Value::Object{{"name", Value(clean(pose.name))}, {"positions", Value(std::move(positions))}});
  }
  Value::Object robot;
  if (!poses.empty()) robot["poses"] = Value(std::move(poses));
  robot["version"] = Value(kVersion);
  robot["bodies"] = Value(std::move(bodies));
  robot["joints"] = Value(std::move(joints));
  Value::Object own;
  own["robot"] = Value(std::move(robot));
  Value::Object extras;
  extras["fire3dv"] = Value(std::move(own));
  return Value(std::move(extras));
}

std::vector<std::string> joint_lines(const Kinematics& kinematics,
                                     const std::vector<std::string>& node_names) {
  std::vector<std::string> lines;
  for (const Joint& joint : kinematics.joints) {
    std::string line = clean(joint.name) + "\t" + name_of(joint.type) + "\t" +
                       node_names[kinematics.bodies[joint.body].node];
    if (joint.limits)
      line += "\tfrom " + text_of(joint.limits->first) + " to " + text_of(joint.limits->second) +
              (joint.type == Joint::Type::prismatic ? " m" : " rad");
    if (joint.mimic)
      line += "\tfollows " + clean(kinematics.joints[joint.mimic->joint].name) + " times " +
              text_of(joint.mimic->multiplier) + " plus " + text_of(joint.mimic->offset);
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace fire3dv::convert
