// Splitters between docks and image, with the handles that fold docks.

#include <algorithm>
#include <cmath>

#include "renderer/gui/widgets.h"

namespace fire3dv::gui {

float Ui::edge(const char* name, bool upright, const Rect& rect) {
  ImGui::SetCursorScreenPos({rect.low.x, rect.low.y});
  invisible_button(name, rect.high.x - rect.low.x, rect.high.y - rect.low.y);
  note_control(Control::Kind::edge, name);
  const bool active = ImGui::IsItemActive();
  if (active || ImGui::IsItemHovered()) {
    ImGui::SetMouseCursor(upright ? ImGuiMouseCursor_ResizeEW : ImGuiMouseCursor_ResizeNS);
    ImGui::GetWindowDrawList()->AddRectFilled(ImGui::GetItemRectMin(), ImGui::GetItemRectMax(),
                                              active ? theme::palette->accent : theme::palette->accent_dark);
  }
  if (!active) return 0;
  return upright ? ImGui::GetIO().MouseDelta.x : ImGui::GetIO().MouseDelta.y;
}

bool Ui::handle(const Splitter& at_edge, const Rect& rect, bool folded) {
  const char* const name = folded ? at_edge.unfold : at_edge.fold;
  ImGui::SetCursorScreenPos({rect.low.x, rect.low.y});
  const bool clicked = invisible_button(name, rect.high.x - rect.low.x, rect.high.y - rect.low.y);
  note_control(Control::Kind::button, name);
  const bool hovered = ImGui::IsItemHovered();
  ImDrawList* const list = ImGui::GetWindowDrawList();
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  list->AddRectFilled(low, high, hovered ? theme::palette->well_hovered : theme::palette->well);
  const ImVec2 at{(low.x + high.x) / 2, (low.y + high.y) / 2};
  const float arm = points(3.5f), half = points(2);
  const ImU32 color = hovered ? theme::palette->accent : theme::palette->dim;
  // The arrow points to where the splitter will be.
  const float way = folded ? -1.0f : 1.0f;
  if (at_edge.arrow == ImGuiDir_Down) {
    list->AddTriangleFilled({at.x - arm, at.y - way * half}, {at.x + arm, at.y - way * half},
                            {at.x, at.y + way * half}, color);
  } else {
    const float side = at_edge.arrow == ImGuiDir_Left ? -way : way;
    list->AddTriangleFilled({at.x - side * half, at.y - arm}, {at.x - side * half, at.y + arm},
                            {at.x + side * half, at.y}, color);
  }
  if (hovered) ImGui::SetMouseCursor(ImGuiMouseCursor_Hand);
  hint(name);
  return clicked;
}

Ui::SplitterUse Ui::splitter(const Splitter& at_edge, const Rect& rect, bool folded) {
  if (folded) return {0, handle(at_edge, rect, true)};
  const bool upright = at_edge.arrow != ImGuiDir_Down;
  const int along = upright ? 1 : 0;
  const float length = rect.high[along] - rect.low[along];
  const float grip = std::min(points(44), std::floor(length / 2));
  Rect first = rect, middle = rect, last = rect;
  first.high[along] = middle.low[along] = rect.low[along] + std::floor((length - grip) / 2);
  middle.high[along] = last.low[along] = middle.low[along] + grip;
  SplitterUse use;
  use.moved_px = edge(at_edge.name, upright, first);
  use.toggled = handle(at_edge, middle, false);
  ImGui::PushID("last");
  use.moved_px += edge(at_edge.name, upright, last);
  ImGui::PopID();
  return use;
}

}  // namespace fire3dv::gui
