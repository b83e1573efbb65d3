// Panel of the joints of the scene's robot: a slider for each revolute and prismatic joint.

#include <algorithm>
#include <numbers>
#include <vector>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {
namespace {

constexpr size_t kMaxRows = 8;  // of the list, which scrolls
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr float kFreeTurn_deg = 180, kFreeWay_m = 1;  // ranges of joints without limits

// Name of the stream that drives the node; nullptr: none does.
const std::string* driver_of(const Shown& shown, uint32_t node) {
  if (node == scene::kNone) return nullptr;
  const uint32_t stream = shown.poses.node_drives()[node].stream;
  return stream == state::kNone ? nullptr : &shown.poses.streams()[stream].name;
}

void draw_joint(const Context& c, const state::RobotPose& robot, size_t index) {
  const robot::RobotJoint& joint = robot.robot().joints()[index];
  const std::string label = one_line(joint.name);
  if (const std::string* driver = driver_of(c.shown, robot.node_of(index))) {
    c.ui.value(label.c_str(), theme::palette->dim, "by " + one_line(*driver));
    c.ui.hint("A stream moves this node; the joint cannot be moved by hand meanwhile");
    return;
  }
  const bool turns = joint.type == robot::JointType::revolute;
  const double unit = turns ? kDegrees : 1;
  const float free = turns ? kFreeTurn_deg : kFreeWay_m;
  Ui::Range range{-free, free, turns ? "%.1f\u00b0" : "%.3f m"};
  if (joint.has_limits) {
    range.least = static_cast<float>(joint.lower * unit);
    range.most = static_cast<float>(joint.upper * unit);
  }
  float shown = static_cast<float>(robot.robot().positions()[joint.position_index] * unit);
  if (!c.ui.slider(label.c_str(), shown, range, turns ? "degrees" : "metres")) return;
  // The slider rounds to the digits that it shows.
  const double position = static_cast<double>(shown) / unit;
  c.view_state.edits.joints[index] = {joint.has_limits ? std::clamp(position, joint.lower, joint.upper)
                                                       : position};
}

// Poses that the description names, the file's, and "by hand" for any other.
void choose_pose(const Context& c, const state::RobotPose& robot) {
  const std::vector<robot::NamedPose>& poses = robot.robot().named_poses();
  if (poses.empty()) return;
  std::vector<std::string> labels{"as in the file"};
  for (const robot::NamedPose& pose : poses) labels.push_back(one_line(pose.name));
  size_t chosen = labels.size();
  if (c.view_state.edits.joints.empty()) chosen = 0;
  for (size_t i = 0; i < poses.size() && chosen == labels.size(); ++i)
    if (robot.robot().positions() == poses[i].positions) chosen = i + 1;
  if (chosen == labels.size()) labels.emplace_back("by hand");
  std::vector<const char*> names;
  for (const std::string& label : labels) names.push_back(label.c_str());
  if (!c.ui.choice("Pose", chosen, names, "A pose that the robot's description names")) return;
  if (chosen == 0) c.view_state.edits.joints.clear();
  if (chosen > 0 && chosen <= poses.size()) c.view_state.edits.joints = robot.positions_of(chosen - 1);
}

}  // namespace

void draw_joints_panel(const Context& c) {
  const state::RobotPose* const robot = c.shown.robot;
  if (!robot) return;
  if (!c.ui.header("Joints", c.layout.is_open(Panel::joints))) return;
  if (c.ui.button("Home##joints", !c.view_state.edits.joints.empty(), "All joints as in the file"))
    c.view_state.edits.joints.clear();
  choose_pose(c, *robot);
  std::vector<size_t> listed;
  for (size_t i = 0; i < robot->robot().joints().size(); ++i)
    if (robot->is_scalar(i)) listed.push_back(i);
  if (listed.empty()) return c.ui.note("No joint turns about or moves along one axis.");

  const float row_height = ImGui::GetFrameHeightWithSpacing();
  const size_t rows = std::min(listed.size(), kMaxRows);
  ImGui::BeginChild("joints", {0, row_height * static_cast<float>(rows)});
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(listed.size()), row_height);
  while (clipper.Step()) {
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const size_t joint = listed[static_cast<size_t>(i)];
      ImGui::PushID(static_cast<int>(joint));
      draw_joint(c, *robot, joint);
      ImGui::PopID();
    }
  }
  ImGui::EndChild();
}

}  // namespace fire3dv::gui
