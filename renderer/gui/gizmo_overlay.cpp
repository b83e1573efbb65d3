#include "renderer/gui/gizmo_overlay.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {
namespace {

// x red, y green, z blue; 3: the plane of the image.
ImU32 axis_color(int axis) {
  return std::array{theme::palette->bad, theme::palette->good, theme::palette->accent,
                    theme::palette->text}[static_cast<size_t>(axis)];
}

glm::mat4 world_from_parent(const Shown& shown, uint32_t node) {
  const uint32_t parent = shown.scene.nodes[node].parent;
  return parent == scene::kNone ? glm::mat4(1) : shown.poses.world_from_node(parent);
}

ImU32 faded(ImU32 color, uint32_t alpha) {
  return (color & ~IM_COL32_A_MASK) | alpha << IM_COL32_A_SHIFT;
}

std::string value_text(app::GizmoTool tool, float value) {
  char text[48];
  if (tool == app::GizmoTool::move) std::snprintf(text, sizeof text, "%.4g m", static_cast<double>(value));
  if (tool == app::GizmoTool::rotate)
    std::snprintf(text, sizeof text, "%.1f\u00b0", static_cast<double>(glm::degrees(value)));
  if (tool == app::GizmoTool::scale) std::snprintf(text, sizeof text, "%.3g x", static_cast<double>(value));
  return text;
}

}  // namespace

state::NodeTransform shown_transform(const Shown& shown, const app::ViewState& view_state, uint32_t node) {
  if (const auto edited = view_state.edits.transforms.find(node); edited != view_state.edits.transforms.end())
    return edited->second;
  const glm::dmat4 parent_from_world = glm::inverse(glm::dmat4(world_from_parent(shown, node)));
  return state::to_transform(glm::mat4(parent_from_world * glm::dmat4(shown.poses.world_from_node(node))));
}

void GizmoOverlay::frame(const Context& c, const Rect& image, const glm::vec2& cursor_px) {
  takes_mouse_ = false;
  const uint32_t node = c.view_state.selected;
  const glm::vec2 size = image.high - image.low;
  const bool is_shown = c.view_state.tool != app::GizmoTool::none && node < c.shown.scene.nodes.size() &&
                        c.shown.view && size.x >= 1 && size.y >= 1;
  const bool is_other = node != node_ || c.shown.scene_number != scene_number_;
  if (!is_shown || is_other) gizmo_.end();
  if (!is_shown) return;
  node_ = node;
  scene_number_ = c.shown.scene_number;
  const GizmoView view{c.shown.view(size.x / size.y), image.low, size};
  const glm::mat4 world_from_node = c.shown.poses.world_from_node(node);
  gizmo_.place(view, world_from_node, c.view_state.tool, c.view_state.tool_is_local, c.ui.scale);
  if (const std::string* const driver = app::direct_driver_of(c.shown.poses, node)) {
    gizmo_.end();
    if (const auto at = view.pixel_of(glm::vec3(world_from_node[3])))
      draw_note(c, image, *at, "driven by " + one_line(*driver) + ": it cannot be moved by hand meanwhile");
    return;
  }
  const ImGuiIO& io = ImGui::GetIO();
  std::optional<size_t> hovered;
  const bool clicked = ImGui::IsMouseClicked(ImGuiMouseButton_Left);
  if (!gizmo_.is_dragging() && !io.WantCaptureMouse && (clicked || !io.MouseDown[0])) {
    hovered = gizmo_.hit(cursor_px);
    if (hovered && clicked) gizmo_.begin(*hovered, cursor_px);
  }
  if (gizmo_.is_dragging() && !follow_drag(c, view, cursor_px)) gizmo_.end();
  takes_mouse_ = hovered || gizmo_.is_dragging();
  draw(c, image, hovered);
}

// False: the button was released.
bool GizmoOverlay::follow_drag(const Context& c, const GizmoView& view, const glm::vec2& cursor_px) {
  const ImGuiIO& io = ImGui::GetIO();
  if (!io.MouseDown[0]) return false;
  const glm::mat4 world_from_node = gizmo_.drag(cursor_px, io.KeyCtrl);
  const glm::dmat4 parent_from_world = glm::inverse(glm::dmat4(world_from_parent(c.shown, node_)));
  const state::NodeTransform wanted =
      state::to_transform(glm::mat4(parent_from_world * glm::dmat4(world_from_node)));
  const bool is_moved = c.view_state.edits.transforms.contains(node_) ||
                        state::parent_from_node(wanted) !=
                            state::parent_from_node(shown_transform(c.shown, c.view_state, node_));
  if (is_moved && state::is_valid(wanted)) c.view_state.edits.transforms[node_] = wanted;
  gizmo_.place(view, world_from_node, c.view_state.tool, c.view_state.tool_is_local, c.ui.scale);
  return true;
}

void GizmoOverlay::draw(const Context& c, const Rect& image, std::optional<size_t> hovered) const {
  ImDrawList* const list = ImGui::GetBackgroundDrawList();
  list->PushClipRect({image.low.x, image.low.y}, {image.high.x, image.high.y});
  const std::vector<GizmoHandle>& handles = gizmo_.handles();
  const auto point = [](const glm::vec2& px) { return ImVec2(px.x, px.y); };
  const float thick = c.ui.points(2.5f);
  for (size_t i = 0; i < handles.size(); ++i) {
    const GizmoHandle& handle = handles[i];
    const bool is_marked = gizmo_.is_dragging() ? gizmo_.is_dragged(handle) : hovered == i;
    const ImU32 color = is_marked ? theme::palette->warning : axis_color(handle.axis);
    switch (handle.kind) {
      case GizmoHandle::Kind::centre:
        list->AddCircleFilled(point(handle.outline[0]), c.ui.points(5), color);
        break;
      case GizmoHandle::Kind::plane:
        list->AddConvexPolyFilled(std::vector<ImVec2>{point(handle.outline[0]), point(handle.outline[1]),
                                                      point(handle.outline[2]), point(handle.outline[3])}
                                      .data(),
                                  4, faded(color, is_marked ? 0xd0 : 0x80));
        break;
      case GizmoHandle::Kind::ring:
        for (const glm::vec2& px : handle.outline) list->PathLineTo(point(px));
        list->PathStroke(handle.axis == 3 && !is_marked ? theme::palette->dim : color, 0, thick);
        break;
      case GizmoHandle::Kind::axis: {
        const glm::vec2 tip = handle.outline[1], way = glm::normalize(tip - handle.outline[0]);
        const glm::vec2 side(-way.y, way.x);
        const float head = c.ui.points(7);
        list->AddLine(point(handle.outline[0]), point(tip), color, thick);
        if (c.view_state.tool == app::GizmoTool::move) {
          list->AddTriangleFilled(point(tip + way * head), point(tip + side * head * 0.6f),
                                  point(tip - side * head * 0.6f), color);
        } else {
          const glm::vec2 half(head * 0.7f);
          list->AddRectFilled(point(tip - half), point(tip + half), color);
        }
        break;
      }
    }
  }
  list->PopClipRect();
  if (gizmo_.is_dragging()) {
    const ImVec2 at = ImGui::GetIO().MousePos;
    draw_note(c, image, {at.x, at.y}, value_text(c.view_state.tool, gizmo_.value()));
  }
}

// Text on a dark ground below and right of a point, within the image.
void GizmoOverlay::draw_note(const Context& c, const Rect& image, const glm::vec2& at,
                             const std::string& text) const {
  ImDrawList* const list = ImGui::GetBackgroundDrawList();
  const float margin = c.ui.points(4), away = c.ui.points(14);
  const std::string shown = elided(text, std::max(image.high.x - image.low.x - 2 * margin, 1.0f));
  const ImVec2 size = ImGui::CalcTextSize(shown.c_str());
  const float max_x = std::max(image.high.x - size.x - margin, image.low.x + margin);
  const float max_y = std::max(image.high.y - size.y - margin, image.low.y + margin);
  const ImVec2 low{std::round(std::clamp(at.x + away, image.low.x + margin, max_x)),
                   std::round(std::clamp(at.y + away, image.low.y + margin, max_y))};
  list->PushClipRect({image.low.x, image.low.y}, {image.high.x, image.high.y});
  list->AddRectFilled({low.x - margin, low.y - margin}, {low.x + size.x + margin, low.y + size.y + margin},
                      faded(theme::palette->panel, 0xe0), margin);
  list->AddText(low, theme::palette->text, shown.c_str());
  list->PopClipRect();
}

}  // namespace fire3dv::gui
