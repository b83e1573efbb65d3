// Node panel: pose of the selected node and the stream that drives it.
#include <glm/gtc/quaternion.hpp>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {
namespace {

uint64_t triangles_of(const scene::Scene& scene, const scene::Node& node) {
  if (node.mesh == scene::kNone) return 0;
  const scene::Mesh& mesh = scene.meshes[node.mesh];
  uint64_t indices = 0;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    if (scene.primitives[p].topology == scene::Topology::triangles)
      indices += scene.primitives[p].index_count;
  }
  return indices / 3;
}

void show_pose(const Context& context, uint32_t node) {
  Ui& ui = context.ui;
  const glm::mat4 world_from_node = context.shown.poses.world_from_node(node);
  const glm::vec3 at = world_from_node[3];
  ui.value("Position", "%.4g  %.4g  %.4g m", static_cast<double>(at.x), static_cast<double>(at.y),
           static_cast<double>(at.z));
  const glm::vec3 x = world_from_node[0], y = world_from_node[1], z = world_from_node[2];
  const glm::vec3 scale{glm::length(x), glm::length(y), glm::length(z)};
  if (scale.x > 0 && scale.y > 0 && scale.z > 0) {
    const glm::mat3 turn{x / scale.x, y / scale.y, z / scale.z};
    const glm::vec3 angles = glm::degrees(glm::eulerAngles(glm::quat_cast(turn)));
    ui.value("Rotation", "%.1f  %.1f  %.1f \u00b0", static_cast<double>(angles.x),
             static_cast<double>(angles.y), static_cast<double>(angles.z));
  }
  if (glm::any(glm::greaterThan(glm::abs(scale - 1.0f), glm::vec3(1e-4f)))) {
    ui.value("Scale", "%.4g  %.4g  %.4g", static_cast<double>(scale.x), static_cast<double>(scale.y),
             static_cast<double>(scale.z));
  }
}

}  // namespace

void draw_node_panel(const Context& context) {
  Ui& ui = context.ui;
  if (!ui.header("Node", context.layout.is_open(Panel::node))) return;
  Viewer& viewer = context.viewer;
  const scene::Scene& scene = context.shown.scene;
  const uint32_t node = viewer.selected;
  const bool any = node < scene.nodes.size();
  const bool hidden = any && viewer.hidden.count(node) != 0;
  if (ui.button(hidden ? "Show##hide" : "Hide##hide", any, "The node and all below it  (H)")) {
    if (hidden) {
      viewer.hidden.erase(node);
    } else {
      viewer.hidden.insert(node);
    }
  }
  ui.same_line();
  const bool isolated = any && viewer.isolated == node;
  if (ui.button("Isolate", any, "Shows only this node and its descendants  (I)", isolated))
    viewer.isolated = isolated ? scene::kNone : node;
  ui.same_line();
  if (ui.button("Focus", any, "The camera shows the whole of it  (F)"))
    viewer.commands.frame_selection = true;
  ui.same_line();
  const bool followed = any && viewer.followed == node;
  if (ui.button("Follow", any, "The camera moves with it", followed))
    viewer.followed = followed ? scene::kNone : node;
  if (!viewer.hidden.empty() || viewer.isolated != scene::kNone) {
    if (ui.button("Show everything", true, "Nothing is hidden or isolated any more")) {
      viewer.hidden.clear();
      viewer.isolated = scene::kNone;
    }
  }
  if (!any) {
    ui.note("Click a body in the image, or a row above.");
    return;
  }

  const scene::Node& n = scene.nodes[node];
  ui.value("Name", theme::kText, node_label(scene, node));
  if (n.path != n.name) ui.value("Path", theme::kDim, n.path);
  const auto& drives = context.shown.poses.node_drives();
  if (node < drives.size() && drives[node].stream != state::kNone &&
      drives[node].stream < context.shown.poses.streams().size()) {
    const state::NodeDrive& drive = drives[node];
    const state::Stream& stream = context.shown.poses.streams()[drive.stream];
    const bool itself = drive.pose_index < stream.scene_node_of_pose.size() &&
                        stream.scene_node_of_pose[drive.pose_index] == node;
    ui.value("Driven by", theme::kAccent, stream.name);
    ui.value("Pose", "%u of %zu%s", drive.pose_index + 1, stream.poses.size(),
             itself ? "" : ", of a node above");
  } else {
    ui.value("Driven by", theme::kDim, "nobody: it rests, or is animated");
  }
  show_pose(context, node);
  if (n.mesh != scene::kNone) {
    const std::string& mesh = scene.meshes[n.mesh].name;
    ui.value("Mesh", theme::kText, mesh.empty() ? "mesh " + std::to_string(n.mesh) : mesh);
    ui.value("Triangles", "%s", grouped(triangles_of(scene, n)).c_str());
  }
}

}  // namespace fire3dv::gui
