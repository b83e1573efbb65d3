#include "protocol/import/plan.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "base/plural.h"
#include "base/text.h"
#include "protocol/frames/frame_tree.h"

namespace fire3dv::imported {
namespace {

using frames::FrameId;
using frames::kNoFrame;

constexpr std::array kFixedNames{"map", "odom", "world"};  // as of fire3dv-ros2

// At most ten names, in quotation marks.
std::string list(const std::vector<std::string>& names) {
  constexpr size_t kMaxNames = 10;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kMaxNames); ++i)
    text += (text.empty() ? "" : ", ") + quote(names[i]);
  return names.size() > kMaxNames ? text + " and " + std::to_string(names.size() - kMaxNames) + " more"
                                  : text;
}

class Planner {
 public:
  Planner(const std::string& file, Survey& survey, LinkPoses* links, const ImportOptions& options)
      : file_(quote(file)), survey_(survey), links_(links), options_(options) {}

  Result<Plan> make();

 private:
  struct Target {
    FrameId frame;
    SceneNode node;
    bool is_whole_name;  // not the last part of a path alone
  };

  const std::string& name_of(FrameId id) const { return survey_.buffer().frames()[id].name; }
  bool is_child(FrameId id) const { return id < survey_.frames().size() && survey_.frames()[id].is_child; }
  Result<void> choose_joints();
  void find_targets();
  Result<void> check_loops();
  Result<void> choose_fixed_frame();
  void drop_fixed_frame();
  void drop_unconnected();
  void drop_shared_nodes();
  void list_unmatched();
  void find_moving();
  void place_stream();

  const std::string file_;
  Survey& survey_;
  LinkPoses* const links_;
  const ImportOptions& options_;
  frames::FrameTree tree_;
  std::vector<Target> targets_;
  std::vector<std::string> unmatched_;
  FrameId fixed_ = kNoFrame;
  Plan plan_;
};

// Transforms of links that move count before joint states, as of fire3dv-ros2. The root link is another
// matter: it may be moved by odometry.
Result<void> Planner::choose_joints() {
  if (survey_.joints().empty()) return {};
  const bool has_moving = std::any_of(survey_.frames().begin(), survey_.frames().end(),
                                      [](const SeenFrame& frame) { return frame.moves && !frame.is_static; });
  if (!links_) {
    if (has_moving) return {};
    return Error{
        file_ +
        " has joint states and no transforms that move, and the scene has no joints: name the robot's "
        "URDF file as the scene"};
  }
  const std::vector<std::string>& frames = links_->frames();
  const bool tf_has_links = std::any_of(frames.begin() + 1, frames.end(), [&](const std::string& frame) {
    const FrameId id = survey_.buffer().find(frame);
    return id != kNoFrame && is_child(id) && !survey_.frames()[id].is_static;
  });
  if (tf_has_links) {
    plan_.notes.push_back("the robot's links have transforms: joint states are not used");
    return {};
  }
  std::vector<std::string> unknown, silent;
  size_t known = 0;
  for (const auto& [joint, position] : survey_.joints()) {
    if (!links_->has_joint(joint))
      unknown.push_back(joint);
    else
      ++known;
  }
  for (const auto& [joint, index] : links_->joints())
    if (!survey_.joints().contains(joint)) silent.push_back(joint);
  if (known == 0) {
    if (has_moving) return {};
    return Error{file_ + ": no joint of its joint states is one of the robot's: " + list(unknown) +
                 "; the robot has " + list(silent)};
  }
  if (!unknown.empty())
    plan_.warnings.push_back("the scene's robot has no such joint, or one that follows another: " +
                             list(unknown));
  if (!silent.empty())
    plan_.warnings.push_back("joints without positions stay as in the scene: " + list(silent));
  plan_.uses_joints = true;
  plan_.links.insert(frames.begin() + 1,
                     frames.end());  // static ones, of fixed joints, follow from joints, too
  for (const auto& [joint, position] : survey_.joints()) links_->set(joint, position);
  for (const TransformSample& link : links_->transforms(survey_.first_joint_ns())) survey_.add_link(link);
  return {};
}

void Planner::find_targets() {
  for (FrameId id = 0; id < survey_.buffer().frames().size(); ++id) {
    const std::string& frame = name_of(id);
    if (!frame.starts_with(options_.frame_prefix)) {
      if (is_child(id)) unmatched_.push_back(frame);
      continue;
    }
    const std::string_view name = std::string_view(frame).substr(options_.frame_prefix.size());
    std::optional<SceneNode> node = options_.find_node(name);
    const bool is_whole = node.has_value();
    if (!node && name.find('/') != name.npos) node = options_.find_node(name.substr(name.rfind('/') + 1));
    if (node)
      targets_.push_back({id, std::move(*node), is_whole});
    else if (is_child(id))
      unmatched_.push_back(frame);
  }
}

Result<void> Planner::check_loops() {
  tree_.begin(survey_.buffer(), 0, std::nullopt);
  for (FrameId id = 0; id < survey_.buffer().frames().size(); ++id) {
    if (tree_.find(id) || !tree_.is_in_loop(id)) continue;
    const FrameId parent = survey_.buffer().frames()[id].samples.back().parent;
    return Error{file_ + ": the parents of frame " + quote(name_of(id)) + " lead back to itself, over " +
                 quote(name_of(parent)) + " (" + survey_.frames()[id].origin +
                 "): record without the publisher that is wrong"};
  }
  // The first frame is the fixed one here, and its own ancestors are not searched for loops.
  FrameId at = 0;
  for (size_t steps = 0; !survey_.buffer().frames()[at].is_root(); ++steps) {
    if (steps > survey_.buffer().frames().size())
      return Error{file_ + ": the parents of frame " + quote(name_of(at)) + " lead back to itself (" +
                   survey_.frames()[at].origin + "): record without the publisher that is wrong"};
    at = survey_.buffer().frames()[at].samples.back().parent;
  }
  return {};
}

Result<void> Planner::choose_fixed_frame() {
  const auto connects = [&](FrameId candidate) {
    tree_.begin(survey_.buffer(), candidate, std::nullopt);
    return std::any_of(targets_.begin(), targets_.end(), [&](const Target& target) {
      return target.frame != candidate && tree_.find(target.frame);
    });
  };
  if (!options_.fixed_frame.empty()) {
    fixed_ = survey_.buffer().find(options_.fixed_frame);
    if (fixed_ == kNoFrame)
      return Error{"--fixed-frame: " + file_ + " has no frame " + quote(options_.fixed_frame)};
    return {};
  }
  for (const char* name : kFixedNames) {
    fixed_ = survey_.buffer().find(name);
    if (fixed_ != kNoFrame && connects(fixed_)) return {};
  }
  tree_.begin(survey_.buffer(), 0, std::nullopt);
  std::unordered_map<FrameId, FrameId> roots;
  std::map<FrameId, size_t> nodes_below;
  for (const Target& target : targets_) ++nodes_below[tree_.root_of(target.frame, roots)];
  size_t most = 0;
  for (const auto& [root, count] : nodes_below) {
    if (count <= most) continue;
    fixed_ = root;
    most = count;
  }
  return {};
}

// A frame such as "map" may have the name of the scene's root node, which is not to be moved.
void Planner::drop_fixed_frame() {
  const std::string& name = name_of(fixed_);
  if (std::find(kFixedNames.begin(), kFixedNames.end(), name) == kFixedNames.end()) return;
  std::erase_if(targets_, [&](const Target& target) { return target.frame == fixed_; });
}

void Planner::drop_unconnected() {
  std::vector<std::string> unconnected;
  tree_.begin(survey_.buffer(), fixed_, std::nullopt);
  std::erase_if(targets_, [&](const Target& target) {
    if (tree_.find(target.frame)) return false;
    // A scene's node that only has the name of a root has no transform to lack.
    if (is_child(target.frame)) unconnected.push_back(name_of(target.frame));
    return true;
  });
  if (!unconnected.empty())
    plan_.warnings.push_back("frames that are not connected to " + quote(name_of(fixed_)) +
                             " are left out: " + list(unconnected));
}

void Planner::drop_shared_nodes() {
  std::map<uint32_t, std::vector<const Target*>> by_node;
  for (const Target& target : targets_) by_node[target.node.index].push_back(&target);
  std::set<FrameId> dropped;
  for (const auto& [node, all] : by_node) {
    if (all.size() == 1) continue;
    const auto whole =
        std::count_if(all.begin(), all.end(), [](const Target* target) { return target->is_whole_name; });
    std::vector<std::string> names;
    for (const Target* target : all) {
      if (whole == 1 && target->is_whole_name) continue;
      dropped.insert(target->frame);
      names.push_back(name_of(target->frame));
    }
    if (whole == 1)
      unmatched_.insert(unmatched_.end(), names.begin(), names.end());
    else
      plan_.warnings.push_back("several frames end with the name of node " + quote(all.front()->node.name) +
                               " and are left out: " + list(names) + "; choose one by --prefix");
  }
  std::erase_if(targets_, [&](const Target& target) { return dropped.contains(target.frame); });
}

void Planner::list_unmatched() {
  if (unmatched_.empty()) return;
  plan_.warnings.push_back(counted(unmatched_.size(), "frame") +
                           (unmatched_.size() == 1 ? " is no node" : " are no nodes") +
                           " of the scene: " + list(unmatched_));
}

// Frames on the ways from nodes to the fixed frame, by the parents of all times.
void Planner::find_moving() {
  std::vector<FrameId> open{fixed_};
  for (const Target& target : targets_) open.push_back(target.frame);
  std::set<FrameId> reached(open.begin(), open.end());
  int64_t first_ns = INT64_MAX, newest_ns = kTimeOffsetNs;
  while (!open.empty()) {
    const FrameId child = open.back();
    open.pop_back();
    plan_.relevant.insert(name_of(child));
    if (is_child(child)) {
      const SeenFrame& frame = survey_.frames()[child];
      newest_ns = std::max(newest_ns, frame.first.stamp_ns);
      if (frame.moves && !frame.is_static) {
        plan_.moving.insert(name_of(child));
        first_ns = std::min(first_ns, frame.first.stamp_ns);
      }
    }
    const auto first = survey_.edges().lower_bound({child, 0});
    for (auto edge = first; edge != survey_.edges().end() && edge->first == child; ++edge)
      if (reached.insert(edge->second).second) open.push_back(edge->second);
  }
  plan_.first_ns = first_ns == INT64_MAX ? newest_ns : first_ns;
}

void Planner::place_stream() {
  // Z up to Y up: (x, y, z) becomes (x, z, -y).
  if (options_.is_z_up) plan_.world_from_stream.m = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};
  if (!plan_.uses_joints || plan_.fixed_frame != links_->frames().front()) return;
  // Joints alone: the robot stands where the scene has it.
  const robot::Transform model_from_root = options_.robot->poses().front();
  plan_.world_from_stream.m = (options_.robot->world_from_model() * model_from_root).m;
}

Result<Plan> Planner::make() {
  if (Result<void> chosen = choose_joints(); !chosen) return chosen.error();
  if (survey_.buffer().frames().empty())
    return Error{
        file_ + " has no transform that is valid" +
        (survey_.faults().sentences().empty() ? std::string() : ": " + survey_.faults().sentences().front())};
  if (Result<void> sound = check_loops(); !sound) return sound.error();
  find_targets();
  if (Result<void> chosen = choose_fixed_frame(); !chosen) return chosen.error();
  if (fixed_ != kNoFrame) {
    drop_fixed_frame();
    drop_unconnected();
    drop_shared_nodes();
  }
  const bool has_nodes = std::any_of(targets_.begin(), targets_.end(),
                                     [&](const Target& target) { return is_child(target.frame); });
  if (!has_nodes && !plan_.warnings.empty()) return Error{file_ + ": " + plan_.warnings.back()};
  if (!has_nodes)
    return Error{file_ + ": no frame has the name of a node of the scene: " + list(unmatched_) +
                 "; name their common beginning by --prefix, or choose another scene"};
  list_unmatched();
  find_moving();
  plan_.fixed_frame = name_of(fixed_);
  place_stream();
  for (Target& target : targets_) {
    plan_.frame_of_node.push_back(name_of(target.frame));
    plan_.nodes.push_back(std::move(target.node));
  }
  for (const SeenFrame& frame : survey_.frames())
    if (frame.is_child) plan_.frames.push_back(frame);
  return std::move(plan_);
}

}  // namespace

Result<Plan> make_plan(const std::string& file, Survey& survey, LinkPoses* links,
                       const ImportOptions& options) {
  return Planner(file, survey, links, options).make();
}

}  // namespace fire3dv::imported
