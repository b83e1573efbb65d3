#include "convert/sdf/sdf_kinematics.h"

#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include "base/text.h"
#include "convert/sdf/names.h"
#include "convert/surfaces.h"

namespace fire3dv::convert {
namespace {

class Tree {
 public:
  Tree(const SdfScene& scene, Model& model, std::vector<std::string>& warnings)
      : scene_(scene), model_(model), warnings_(warnings) {}

  void build() {
    for (size_t i = 0; i < scene_.items.size(); ++i) {
      const glm::dmat4 in_parent = matrix_of(scene_.items[i].translation, scene_.items[i].rotation);
      world_from_item_.push_back(
          scene_.items[i].parent ? world_from_item_[*scene_.items[i].parent] * in_parent : in_parent);
    }
    choose_joints();
    add_bodies();
    name_joints();
    for (const size_t joint : chosen_) add_joint(joint);
    for (const size_t joint : chosen_) add_mimics(joint);
    for (const std::string& name : drop_mimic_loops(model_.kinematics.joints))
      warnings_.push_back("joint " + quote(name) + " mimics itself, over others; it moves by itself");
  }

 private:
  // One joint moves a link; others of the same child, and those that lead back, close loops.
  void choose_joints() {
    std::map<size_t, size_t> root_of;  // union of links that are connected, path by path
    const auto find = [&](size_t link) {
      root_of.try_emplace(link, link);
      while (root_of[link] != link) {
        root_of[link] = root_of[root_of[link]];
        link = root_of[link];
      }
      return link;
    };
    for (size_t i = 0; i < scene_.joints.size(); ++i) {
      const SdfJoint& joint = scene_.joints[i];
      const size_t child = find(joint.child);
      bool closes = joint_of_.contains(joint.child);
      if (joint.parent) {
        const size_t parent = find(*joint.parent);
        closes = closes || parent == child;
        if (!closes) root_of[child] = parent;
      }
      if (closes) {
        warnings_.push_back("joint " + quote(joint.name) + " closes a loop and is left out: link " +
                            quote(model_.nodes[joint.child].name) + " hangs on another joint");
        continue;
      }
      joint_of_[joint.child] = i;
      chosen_.push_back(i);
      links_.insert(joint.child);
      if (joint.parent) links_.insert(*joint.parent);
    }
  }

  // Parents precede children.
  void add_bodies() {
    std::multimap<size_t, size_t> children;
    std::vector<size_t> order;
    for (const size_t link : links_) {
      const auto joint = joint_of_.find(link);
      if (joint != joint_of_.end() && scene_.joints[joint->second].parent)
        children.emplace(*scene_.joints[joint->second].parent, link);
      else
        order.push_back(link);
    }
    for (size_t i = 0; i < order.size(); ++i) {
      const auto [first, last] = children.equal_range(order[i]);
      for (auto child = first; child != last; ++child) order.push_back(child->second);
    }
    for (const size_t link : order) {
      Body body;
      body.node = link;
      glm::dmat4 pose = world_from_item_[link];
      const auto joint = joint_of_.find(link);
      if (joint != joint_of_.end() && scene_.joints[joint->second].parent) {
        const size_t parent = *scene_.joints[joint->second].parent;
        body.parent = body_of_.at(parent);
        pose = glm::inverse(world_from_item_[parent]) * pose;
      }
      body.translation = glm::dvec3(pose[3]);
      body.rotation = glm::normalize(glm::quat_cast(glm::dmat3(pose)));
      body_of_[link] = model_.kinematics.bodies.size();
      model_.kinematics.bodies.push_back(body);
    }
  }

  void name_joints() {
    std::map<std::string, int> uses;
    for (const size_t i : chosen_) ++uses[escaped_sdf_name(scene_.joints[i].name)];
    SdfNames names;
    for (const bool is_unique : {true, false}) {
      for (const size_t i : chosen_) {
        const SdfJoint& joint = scene_.joints[i];
        const std::string own = escaped_sdf_name(joint.name);
        if ((uses[own] == 1) != is_unique) continue;
        names_[i] =
            names.take(is_unique ? own : model_.nodes[joint.model].name + "/" + own, SdfEntity::model);
      }
    }
    taken_ = std::move(names);
  }

  void add_joint(size_t index) {
    const SdfJoint& from = scene_.joints[index];
    Joint joint;
    joint.name = names_[index];
    joint.type = from.type;
    joint.body = body_of_.at(from.child);
    joint.anchor = from.anchor;
    if (from.type == Joint::Type::ball) joint.initial = {0, 0, 0, 1};
    joints_by_name_.emplace(std::pair(from.model, from.name), model_.kinematics.joints.size());
    if (from.axes.empty()) {
      model_.kinematics.joints.push_back(std::move(joint));
      return;
    }
    for (size_t axis = 0; axis < from.axes.size(); ++axis) {
      Joint each = joint;
      if (axis > 0) each.name = taken_.take(joint.name + "#2", SdfEntity::model);
      each.axis = from.axes[axis].direction;
      each.limits = from.axes[axis].limits;
      each.initial = {0};
      model_.kinematics.joints.push_back(std::move(each));
    }
  }

  void add_mimics(size_t index) {
    const SdfJoint& from = scene_.joints[index];
    if (from.axes.empty() || !from.axes.front().mimic) return;
    const SdfJoint::Axis::Mimic& mimic = *from.axes.front().mimic;
    Joint& joint = model_.kinematics.joints[joints_by_name_.at({from.model, from.name})];
    const auto leader = joints_by_name_.find({from.model, mimic.joint});
    const bool can_lead =
        leader != joints_by_name_.end() && positions_of(model_.kinematics.joints[leader->second].type) == 1;
    if (can_lead)
      joint.mimic = Joint::Mimic{leader->second, mimic.multiplier, mimic.offset};
    else
      warnings_.push_back("joint " + quote(joint.name) + " mimics " + quote(mimic.joint) +
                          ", which is not a revolute or prismatic joint of its model; it moves by itself");
  }

  const SdfScene& scene_;
  Model& model_;
  std::vector<std::string>& warnings_;
  std::vector<glm::dmat4> world_from_item_;
  std::vector<size_t> chosen_;         // joints of the tree
  std::map<size_t, size_t> joint_of_;  // by child
  std::set<size_t> links_;
  std::map<size_t, size_t> body_of_;     // by link
  std::map<size_t, std::string> names_;  // by joint
  SdfNames taken_;
  std::map<std::pair<size_t, std::string>, size_t> joints_by_name_;  // by model; index into the kinematics
};

}  // namespace

void add_sdf_kinematics(const SdfScene& scene, Model& model, std::vector<std::string>& warnings) {
  Tree(scene, model, warnings).build();
}

}  // namespace fire3dv::convert
