#include "convert/mjcf/bodies/mjcf_joints.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "convert/mjcf/assets/mjcf_source.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxJointChecks = 10'000'000;  // of couplings, over all copies

// Numbers of a joint, with quaternions as x y z w.
std::vector<double> position_of(const MjcfJoint& joint, const MjcfCoordinates& coordinates) {
  const double* const values = &coordinates.values[joint.first_coordinate];
  std::vector<double> position;
  if (joint.type == MjcfJoint::Type::free) position.assign(values, values + 3);
  if (joint.type == MjcfJoint::Type::slide || joint.type == MjcfJoint::Type::hinge) return {values[0]};
  const double* const wxyz = values + position.size();
  const glm::dquat given(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  const bool has_length = glm::length(given) > 1e-15;
  const glm::dquat unit = has_length ? glm::normalize(given) : glm::dquat(1, 0, 0, 0);
  position.insert(position.end(), {unit.x, unit.y, unit.z, unit.w});
  return position;
}

class KinematicsBuilder {
 public:
  KinematicsBuilder(const MjcfTree& tree, const MjcfCoordinates& coordinates)
      : tree_(tree), coordinates_(coordinates) {}

  Kinematics build() {
    find_names();
    for (size_t i = 1; i < tree_.bodies.size(); ++i) add_body(i);
    add_couplings();
    if (!tree_.copies.empty())
      for (const std::string& name : drop_mimic_loops(made_.joints))
        tree_.copies.front().source->messages().warn(
            "joint " + quote(name) + " is coupled to itself, over others; it moves by itself");
    return std::move(made_);
  }

 private:
  // Named joints come first, so that generated names cannot take theirs.
  void find_names() {
    std::vector<std::string> own;
    for (const MjcfTreeBody& body : tree_.bodies)
      for (const MjcfJoint& joint : body.joints) own.push_back(joint.name);
    names_.resize(own.size());
    std::set<std::string> taken;
    for (const bool has_name : {true, false})
      for (size_t i = 0; i < own.size(); ++i) {
        if (own[i].empty() == has_name) continue;
        const std::string name = has_name ? own[i] : "joint_" + std::to_string(i);
        names_[i] = name;
        for (int n = 0; !taken.insert(names_[i]).second; ++n)
          names_[i] = name + " joint" + (n ? " " + std::to_string(n) : "");
      }
  }

  void add_body(size_t index) {
    const MjcfTreeBody& from = tree_.bodies[index];
    Body body;
    body.node = index;
    if (from.parent && *from.parent > 0) body.parent = *from.parent - 1;
    MjcfPose pose = from.pose;
    // The world is a body without a pose of its own.
    if (const auto mocap = coordinates_.mocap.find(index); mocap != coordinates_.mocap.end()) {
      pose = mocap->second;
      body.parent.reset();
    }
    for (const MjcfJoint& joint : from.joints) {
      if (joint.type != MjcfJoint::Type::free) continue;
      pose = {};  // its position is that in the world
      body.parent.reset();
    }
    body.translation = pose.position;
    body.rotation = pose.rotation;
    made_.bodies.push_back(body);
    for (const MjcfJoint& joint : from.joints) add_joint(joint);
  }

  void add_joint(const MjcfJoint& from) {
    Joint joint;
    joint.name = names_[made_.joints.size()];
    joint.body = made_.bodies.size() - 1;
    joint.anchor = from.position;
    joint.initial = position_of(from, coordinates_);
    switch (from.type) {
      case MjcfJoint::Type::free:
        joint.type = Joint::Type::floating;
        break;
      case MjcfJoint::Type::ball:
        joint.type = Joint::Type::ball;
        break;
      case MjcfJoint::Type::slide:
      case MjcfJoint::Type::hinge:
        joint.type = from.type == MjcfJoint::Type::slide ? Joint::Type::prismatic : Joint::Type::revolute;
        joint.axis = from.axis;
        joint.reference = from.reference;
        if (from.range) joint.limits = std::pair(from.range->x, from.range->y);
        break;
    }
    made_.joints.push_back(std::move(joint));
  }

  std::optional<size_t> joint_called(const std::string& name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end()) return std::nullopt;
    const auto index = static_cast<size_t>(found - names_.begin());
    const Joint::Type type = made_.joints[index].type;
    if (type != Joint::Type::revolute && type != Joint::Type::prismatic) return std::nullopt;
    return index;
  }

  void add_couplings() {
    size_t checks = 0;
    for (const MjcfCopy& copy : tree_.copies)
      for (const MjcfElement& section : copy.source->root().children) {
        if (section.kind != "equality") continue;
        for (const MjcfElement& element : section.children) {
          if (element.kind != "joint") continue;
          checks += names_.size() + 1;
          if (checks > kMaxJointChecks) return;
          add_coupling(element, copy);
        }
      }
  }

  // joint1 - ref1 = polynomial of (joint2 - ref2).
  void add_coupling(const MjcfElement& element, const MjcfCopy& copy) {
    MjcfSource& source = *copy.source;
    const size_t class_index = source.class_of(element, MjcfDefaults::kMain);
    const MjcfAttributes from = source.attributes(element, class_index, "equality");
    if (!from.flag("active", true)) return;
    const auto in_copy = [&](const char* attribute) {
      return copy.prefix + from.text(attribute) + copy.suffix;
    };
    const std::optional<size_t> follower = joint_called(in_copy("joint1")),
                                leader = joint_called(in_copy("joint2"));
    if (!follower || !leader) return;  // of another copy, or a joint that is held in place
    Joint& joint = made_.joints[*follower];
    if (joint.mimic) return;
    std::array<double, 5> coefficients{0, 1, 0, 0, 0};  // fewer may be given
    const std::vector<double> given = mjcf_numbers(from.text("polycoef"), coefficients.size());
    std::copy(given.begin(), given.end(), coefficients.begin());
    if (coefficients[2] != 0 || coefficients[3] != 0 || coefficients[4] != 0) {
      from.warn("the coupling is not linear: " + quote(joint.name) + " moves by itself");
      return;
    }
    const double multiplier = coefficients[1];
    joint.mimic =
        Joint::Mimic{*leader, multiplier,
                     joint.reference + coefficients[0] - multiplier * made_.joints[*leader].reference};
  }

  const MjcfTree& tree_;
  const MjcfCoordinates& coordinates_;
  Kinematics made_;
  std::vector<std::string> names_;  // of all joints, in MuJoCo's order
};

}  // namespace

Kinematics mjcf_kinematics(const MjcfTree& tree, const MjcfCoordinates& coordinates) {
  return KinematicsBuilder(tree, coordinates).build();
}

std::vector<double> mjcf_positions(const MjcfTree& tree, const MjcfCoordinates& coordinates) {
  std::vector<double> positions;
  for (size_t i = 1; i < tree.bodies.size(); ++i)
    for (const MjcfJoint& joint : tree.bodies[i].joints) {
      const std::vector<double> own = position_of(joint, coordinates);
      positions.insert(positions.end(), own.begin(), own.end());
    }
  return positions;
}

}  // namespace fire3dv::convert
