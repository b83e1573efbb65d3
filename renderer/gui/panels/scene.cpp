// Panels of the scene's nodes: scene tree (search, selection and visibility), selected node, cameras.

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <string_view>
#include <unordered_map>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {

void TreePanel::take_scene(const scene::Scene& scene, uint64_t number) {
  if (scene_ == &scene && scene_number_ == number && open_.size() == scene.nodes.size()) return;
  scene_ = &scene;
  scene_number_ = number;
  const auto count = static_cast<uint32_t>(scene.nodes.size());
  roots_.clear();
  first_child_.assign(count + 1, 0);
  for (uint32_t node = 0; node < count; ++node) {
    const uint32_t parent = scene.nodes[node].parent;
    if (parent == scene::kNone) {
      roots_.push_back(node);
    } else {
      ++first_child_[parent + 1];
    }
  }
  for (uint32_t node = 0; node < count; ++node) first_child_[node + 1] += first_child_[node];
  children_.resize(first_child_[count]);
  std::vector<uint32_t> next(first_child_.begin(), first_child_.end() - 1);
  for (uint32_t node = 0; node < count; ++node) {
    const uint32_t parent = scene.nodes[node].parent;
    if (parent != scene::kNone) children_[next[parent]++] = node;
  }
  // Small scenes start fully expanded, large ones with their first levels. Nodes that the scene before had,
  // as in a scene with one more object, stay as they are.
  std::unordered_map<uint64_t, bool> was_open;
  for (size_t node = 0; node < path_hashes_.size(); ++node) was_open[path_hashes_[node]] = open_[node];
  open_.assign(count, count <= 64);
  if (roots_.size() == 1) open_[roots_[0]] = true;
  path_hashes_.resize(count);
  for (uint32_t node = 0; node < count; ++node) {
    path_hashes_[node] = std::hash<std::string_view>()(scene.nodes[node].path);
    if (const auto known = was_open.find(path_hashes_[node]); known != was_open.end())
      open_[node] = known->second;
  }
  rows_are_old_ = true;
  revealed_ = scene::kNone;
}

void TreePanel::list_rows(const scene::Scene& scene) {
  rows_.clear();
  rows_are_old_ = false;
  if (!search_.empty()) {
    for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
      if (contains_no_case(scene.nodes[node].name, search_)) rows_.push_back({node, 0});
    }
    return;
  }
  std::vector<Row> waiting;
  for (auto root = roots_.rbegin(); root != roots_.rend(); ++root) waiting.push_back({*root, 0});
  while (!waiting.empty()) {
    const Row row = waiting.back();
    waiting.pop_back();
    rows_.push_back(row);
    if (!open_[row.node]) continue;
    for (uint32_t i = first_child_[row.node + 1]; i-- > first_child_[row.node];)
      waiting.push_back({children_[i], row.depth + 1});
  }
}

// Scrolls to a node that was selected elsewhere.
void TreePanel::reveal(const scene::Scene& scene, uint32_t node) {
  revealed_ = node;
  if (node >= scene.nodes.size()) return;
  scroll_to_selection_ = true;
  for (uint32_t above = scene.nodes[node].parent; above != scene::kNone; above = scene.nodes[above].parent) {
    if (open_[above]) continue;
    open_[above] = true;
    rows_are_old_ = true;
  }
}

namespace {

// The shown file, and those of earlier runs to open instead.
void choose_file(const Context& context) {
  const auto files = context.shown.recent_files;
  if (files.size() < 2) return;
  std::vector<std::string> labels;
  for (const std::filesystem::path& file : files)
    labels.push_back(one_line(file.filename().string() + "  (" + file.parent_path().string() + ")"));
  std::vector<const char*> names;
  for (const std::string& label : labels) names.push_back(label.c_str());
  size_t chosen = 0;
  if (context.ui.choice("File", chosen, names, "Opens a recent file"))
    context.view_state.commands.open = files[chosen];
}

}  // namespace

void TreePanel::draw(const Context& context, float height_px) {
  Ui& ui = context.ui;
  rows_drawn_ = 0;
  if (!ui.header("Scene", context.layout.is_open(Panel::tree))) return;
  choose_file(context);
  const scene::Scene& scene = context.shown.scene;
  take_scene(scene, context.shown.scene_number);
  if (context.view_state.selected != revealed_) reveal(scene, context.view_state.selected);
  const std::string hint = "Search " + grouped(scene.nodes.size()) + " nodes";
  if (ui.text("Search", hint.c_str(), search_)) rows_are_old_ = true;
  if (rows_are_old_) list_rows(scene);

  const float row_height = ImGui::GetTextLineHeightWithSpacing();
  ImGui::BeginChild("tree", {0, height_px});
  if (scroll_to_selection_) {
    const auto row = std::find_if(rows_.begin(), rows_.end(),
                                  [&](const Row& r) { return r.node == context.view_state.selected; });
    if (row != rows_.end()) {
      const float y = static_cast<float>(row - rows_.begin()) * row_height;
      const float top = ImGui::GetScrollY(), room = ImGui::GetWindowHeight();
      if (y < top || y + row_height > top + room) ImGui::SetScrollY(std::max(0.0f, y - room / 3));
    }
    scroll_to_selection_ = false;
  }
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(rows_.size()), row_height);
  while (clipper.Step()) {
    // Expansion changes in a row take effect in the next frame.
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i)
      draw_row(context, rows_[static_cast<size_t>(i)]);
  }
  ImGui::EndChild();
  if (!search_.empty()) ui.note(grouped(rows_.size()) + " found");
}

void TreePanel::draw_row(const Context& context, const Row& row) {
  Ui& ui = context.ui;
  app::ViewState& view_state = context.view_state;
  const scene::Scene& scene = context.shown.scene;
  const uint32_t node = row.node;
  ++rows_drawn_;
  ImGui::PushID(static_cast<int>(node));
  const float sign_width = ui.points(18), left = ImGui::GetCursorPosX();
  const float width = ImGui::GetContentRegionAvail().x;
  // Names of deep nodes keep half of a narrow column.
  const float indent =
      std::floor(std::min(ui.points(12) * static_cast<float>(std::min(row.depth, 24u)), width * 0.4f));
  ImGui::SetCursorPosX(left + indent);
  if (search_.empty() && has_children(node)) {
    if (ui.sign(open_[node] ? "Close" : "Open", open_[node] ? "\u25be" : "\u25b8", theme::palette->dim,
                ui.points(14))) {
      open_[node] = !open_[node];
      rows_are_old_ = true;
    }
  } else {
    ImGui::Dummy({ui.points(14), 1});
  }
  ImGui::SameLine(0, 0);

  const bool hidden = view_state.edits.hidden.count(node) != 0;
  const bool gone = context.shown.edits && context.shown.edits->is_hidden(node);
  const auto& drives = context.shown.poses.node_drives();
  const bool driven = node < drives.size() && drives[node].stream != state::kNone;
  const ImU32 color = hidden || gone ? theme::palette->faint
                      : driven       ? theme::palette->text
                                     : theme::palette->dim;
  const std::string label = node_label(scene, node);
  const float room = width - indent - ui.points(14) - sign_width;
  if (ui.row(label.c_str(), view_state.selected == node, color, std::max(room, ui.points(20)))) {
    view_state.selected = node;
    revealed_ = node;
  }
  if (ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(0)) view_state.commands.frame_selection = true;
  ImGui::SameLine(left + width - sign_width);
  if (ui.sign(hidden ? "Show" : "Hide", hidden ? "\u25cb" : "\u25cf",
              hidden ? theme::palette->text : theme::palette->faint, sign_width)) {
    if (hidden) {
      view_state.edits.hidden.erase(node);
    } else {
      view_state.edits.hidden.insert(node);
    }
  }
  ImGui::PopID();
}

// --- node panel: pose of the selected node and the stream that drives it ---

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
  const glm::vec3 at = without_rounding(world_from_node[3]);
  ui.value("Position", "%.4g  %.4g  %.4g m", static_cast<double>(at.x), static_cast<double>(at.y),
           static_cast<double>(at.z));
  const glm::vec3 x = world_from_node[0], y = world_from_node[1], z = world_from_node[2];
  const glm::vec3 scale{glm::length(x), glm::length(y), glm::length(z)};
  if (scale.x > 0 && scale.y > 0 && scale.z > 0) {
    const glm::mat3 turn{x / scale.x, y / scale.y, z / scale.z};
    // In tenths; the sum makes a negative 0 positive.
    const glm::vec3 angles =
        glm::round(10.0f * glm::degrees(glm::eulerAngles(glm::quat_cast(turn)))) / 10.0f + 0.0f;
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
  app::ViewState& view_state = context.view_state;
  const scene::Scene& scene = context.shown.scene;
  const uint32_t node = view_state.selected;
  const bool any = node < scene.nodes.size();
  const bool hidden = any && view_state.edits.hidden.count(node) != 0;
  if (ui.button(hidden ? "Show##hide" : "Hide##hide", any, "The node and all below it  (H)")) {
    if (hidden) {
      view_state.edits.hidden.erase(node);
    } else {
      view_state.edits.hidden.insert(node);
    }
  }
  ui.same_line();
  const bool isolated = any && view_state.edits.isolated == node;
  if (ui.button("Isolate", any, "Shows only this node and its descendants  (I)", isolated))
    view_state.edits.isolated = isolated ? scene::kNone : node;
  ui.same_line();
  if (ui.button("Focus", any, "The camera shows the whole of it  (F)"))
    view_state.commands.frame_selection = true;
  ui.same_line();
  const bool followed = any && view_state.followed == node;
  if (ui.button("Follow", any, "The camera moves with it", followed))
    view_state.followed = followed ? scene::kNone : node;
  if (!view_state.edits.hidden.empty() || view_state.edits.isolated != scene::kNone) {
    if (ui.button("Show everything", true, "Nothing is hidden or isolated any more")) {
      view_state.edits.hidden.clear();
      view_state.edits.isolated = scene::kNone;
    }
  }
  if (!any) {
    ui.note("Click a body in the image, or a row above.");
    return;
  }

  const scene::Node& n = scene.nodes[node];
  ui.value("Name", theme::palette->text, node_label(scene, node));
  if (n.path != n.name) ui.value("Path", theme::palette->dim, n.path);
  const auto& drives = context.shown.poses.node_drives();
  if (node < drives.size() && drives[node].stream != state::kNone &&
      drives[node].stream < context.shown.poses.streams().size()) {
    const state::NodeDrive& drive = drives[node];
    const state::Stream& stream = context.shown.poses.streams()[drive.stream];
    const bool itself = drive.pose_index < stream.scene_node_of_pose.size() &&
                        stream.scene_node_of_pose[drive.pose_index] == node;
    ui.value("Driven by", theme::palette->accent, stream.name);
    ui.value("Pose", "%u of %zu%s", drive.pose_index + 1, stream.poses.size(),
             itself ? "" : ", of a node above");
  } else {
    ui.value("Driven by", theme::palette->dim, "nobody: it rests, or is animated");
  }
  show_pose(context, node);
  if (n.mesh != scene::kNone) {
    const std::string& mesh = scene.meshes[n.mesh].name;
    ui.value("Mesh", theme::palette->text, mesh.empty() ? "mesh " + std::to_string(n.mesh) : mesh);
    ui.value("Triangles", "%s", grouped(triangles_of(scene, n)).c_str());
  }
}

// --- cameras panel: selection of a scene camera or the free camera, and its speed ---

void CamerasPanel::draw(const Context& context) {
  Ui& ui = context.ui;
  if (!ui.header("Cameras", context.layout.is_open(Panel::cameras))) return;
  app::ViewState& view_state = context.view_state;
  const scene::Scene& scene = context.shown.scene;
  const std::optional<size_t> now = context.facts.camera;
  if (scene_number_ != context.shown.scene_number) {
    scene_number_ = context.shown.scene_number;
    nodes_ = scene::camera_nodes(scene);  // visits every node
  }
  if (ui.row("Free camera", !now)) view_state.commands.free_camera = true;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    std::string text = node_label(scene, nodes_[i]);
    if (i < 9) text = std::to_string(i + 1) + "  " + text;  // shortcut key
    if (ui.row(text.c_str(), now == i)) view_state.commands.camera = i;
    ImGui::PopID();
  }
  if (ui.button("Frame all", true, "The whole scene  (Home)")) view_state.commands.frame_all = true;
  ui.same_line();
  if (ui.button("Frame selection", view_state.selected < scene.nodes.size(), "The selected node  (F)"))
    view_state.commands.frame_selection = true;
  if (view_state.followed < scene.nodes.size()) {
    ui.value("Follows", theme::palette->accent, node_label(scene, view_state.followed));
    if (ui.button("Stop following")) view_state.followed = scene::kNone;
  }
  ui.slider("Speed", view_state.camera_speed, {0.05f, 20, "%.2f x", true},
            "Factor on the speed that the scene's size implies");
}

}  // namespace fire3dv::gui
