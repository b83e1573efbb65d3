// Cameras panel: selection of a scene camera or the free camera, and its speed.
#include "renderer/gui/panels.h"

namespace fire3dv::gui {

void CamerasPanel::draw(const Context& context) {
  Ui& ui = context.ui;
  if (!ui.header("Cameras", context.layout.is_open(Panel::cameras))) return;
  Viewer& viewer = context.viewer;
  const scene::Scene& scene = context.shown.scene;
  const std::optional<size_t> now = context.facts.camera;
  if (scene_number_ != context.shown.scene_number) {
    scene_number_ = context.shown.scene_number;
    nodes_ = scene::camera_nodes(scene);  // visits every node
  }
  if (ui.row("Free camera", !now)) viewer.commands.free_camera = true;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    std::string text = node_label(scene, nodes_[i]);
    if (i < 9) text = std::to_string(i + 1) + "  " + text;  // shortcut key
    if (ui.row(text.c_str(), now == i)) viewer.commands.camera = i;
    ImGui::PopID();
  }
  if (ui.button("Frame all", true, "The whole scene  (Home)")) viewer.commands.frame_all = true;
  ui.same_line();
  if (ui.button("Frame selection", viewer.selected < scene.nodes.size(), "The selected node  (F)"))
    viewer.commands.frame_selection = true;
  if (viewer.followed < scene.nodes.size()) {
    ui.value("Follows", theme::kAccent, node_label(scene, viewer.followed));
    if (ui.button("Stop following")) viewer.followed = scene::kNone;
  }
  ui.slider("Speed", viewer.camera_speed, {0.05f, 20, "%.2f x", true},
            "Factor on the speed that the scene's size implies");
}

}  // namespace fire3dv::gui
