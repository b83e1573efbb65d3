#include "convert/sdf/library/sdf_joints.h"

#include <cmath>
#include <optional>
#include <sdf/Element.hh>
#include <sdf/Joint.hh>
#include <sdf/JointAxis.hh>

#include "base/text.h"
#include "convert/sdf/library/sdf_values.h"

namespace fire3dv::convert {
namespace {

// Limits beyond are none: SDF writes 1e16.
constexpr double kUnlimited = 1e15;

struct Kind {
  Joint::Type type = Joint::Type::fixed;
  unsigned axes = 0;
  const char* loss = nullptr;
};

Kind kind_of(sdf::JointType type) {
  switch (type) {
    case sdf::JointType::REVOLUTE:
    case sdf::JointType::CONTINUOUS:
      return {Joint::Type::revolute, 1};
    case sdf::JointType::PRISMATIC:
      return {Joint::Type::prismatic, 1};
    case sdf::JointType::REVOLUTE2:
    case sdf::JointType::UNIVERSAL:
      return {Joint::Type::revolute, 2};
    case sdf::JointType::BALL:
      return {Joint::Type::ball, 0};
    case sdf::JointType::SCREW:
      return {Joint::Type::revolute, 1, "a screw turns without moving along its axis"};
    case sdf::JointType::GEARBOX:
      return {Joint::Type::revolute, 1, "a gearbox turns without its gears"};
    case sdf::JointType::FIXED:
      return {};
    case sdf::JointType::INVALID:
      break;
  }
  return {Joint::Type::fixed, 0, "its type is unknown, so it is fixed"};
}

// SDF 1.11: follower = multiplier * (leader - reference) + offset.
std::optional<SdfJoint::Axis::Mimic> mimic_of(const sdf::JointAxis& axis) {
  const sdf::ElementPtr element = axis.Element();
  const sdf::ElementPtr from = element ? element->FindElement("mimic") : nullptr;
  if (!from || !from->HasAttribute("joint")) return std::nullopt;
  const auto number = [&](const char* name) {
    const sdf::ElementPtr child = from->FindElement(name);
    return child ? child->Get<double>("", 0).first : 0;
  };
  SdfJoint::Axis::Mimic made;
  made.joint = from->Get<std::string>("joint");
  made.multiplier = number("multiplier");
  made.offset = number("offset") - made.multiplier * number("reference");
  if (!std::isfinite(made.multiplier) || !std::isfinite(made.offset)) return std::nullopt;
  return made;
}

std::optional<SdfJoint::Axis> axis_of(const sdf::Joint& joint, unsigned index, const std::string& child) {
  const sdf::JointAxis* from = joint.Axis(index);
  ignition::math::Vector3d xyz;
  if (!from || !from->ResolveXyz(xyz, child).empty()) return std::nullopt;
  SdfJoint::Axis made;
  made.direction = vec3(xyz);
  const double length = glm::length(made.direction);
  if (!(length > 1e-9) || !std::isfinite(length)) return std::nullopt;
  made.direction /= length;
  const double lower = from->Lower(), upper = from->Upper();
  const bool is_limited = joint.Type() != sdf::JointType::CONTINUOUS && lower <= upper &&
                          std::abs(lower) < kUnlimited && std::abs(upper) < kUnlimited;
  if (is_limited) made.limits = {lower, upper};
  made.mimic = mimic_of(*from);
  return made;
}

}  // namespace

void add_sdf_joints(const sdf::Model& model, size_t item, const std::string& prefix,
                    const std::map<std::string, size_t>& links, const std::string& where, SdfScene& scene,
                    std::vector<std::string>& warnings) {
  for (uint64_t i = 0; i < model.JointCount(); ++i) {
    const sdf::Joint& from = *model.JointByIndex(i);
    const std::string location = where + ", joint " + quote(from.Name()) + ": ";
    SdfJoint made;
    made.name = from.Name();
    made.model = item;
    std::string parent, child;
    const bool is_child_known = from.ResolveChildLink(child).empty() && links.contains(prefix + child);
    const bool is_parent_known =
        from.ResolveParentLink(parent).empty() && (parent == "world" || links.contains(prefix + parent));
    if (!is_child_known || !is_parent_known) {
      warnings.push_back(location + "its " + (is_child_known ? "parent " : "child ") +
                         quote(is_child_known ? from.ParentLinkName() : from.ChildLinkName()) +
                         " is not a link; the joint is left out");
      continue;
    }
    made.child = links.at(prefix + child);
    if (parent != "world") made.parent = links.at(prefix + parent);
    const Kind kind = kind_of(from.Type());
    made.type = kind.type;
    if (kind.loss) warnings.push_back(location + kind.loss);
    ignition::math::Pose3d pose;
    if (!from.SemanticPose().Resolve(pose, child).empty() || !is_sound(pose)) pose = {};
    made.anchor = vec3(pose.Pos());
    for (unsigned axis = 0; axis < kind.axes; ++axis) {
      if (std::optional<SdfJoint::Axis> resolved = axis_of(from, axis, child))
        made.axes.push_back(*resolved);
      else
        warnings.push_back(location + "an axis has no direction; the joint is fixed about it");
    }
    if (kind.axes > 0 && made.axes.empty()) made.type = Joint::Type::fixed;
    scene.joints.push_back(std::move(made));
  }
}

}  // namespace fire3dv::convert
