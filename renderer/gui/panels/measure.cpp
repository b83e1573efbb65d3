// Panel of picked points: coordinates in the world and in the node's frame, and the distance between two
// points.

#include <algorithm>
#include <cstdio>
#include <glm/glm.hpp>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {
namespace {

// Three numbers need more room than the column of values has.
void show_text(Ui& ui, const char* label, const char* text) {
  constexpr float kLabelPt = 58;
  ImGui::TextColored(theme::floats(theme::palette->dim), "%s", label);
  ImGui::SameLine(ImGui::GetCursorPosX() + ui.points(kLabelPt));
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(wrapped(text, ImGui::GetContentRegionAvail().x).c_str());
  ImGui::PopTextWrapPos();
}

void show_vector(Ui& ui, const char* label, glm::vec3 metres) {
  const glm::dvec3 shown(without_rounding(metres));
  char text[80];
  std::snprintf(text, sizeof text, "%.5g %.5g %.5g m", shown.x, shown.y, shown.z);
  show_text(ui, label, text);
}

void show_distance(const Context& c) {
  const std::vector<app::SurfacePoint>& measured = c.view_state.measured;
  if (!measured.empty()) show_vector(c.ui, "From", app::position_world(measured[0], c.shown.poses));
  if (measured.size() < 2) {
    c.ui.note(measured.empty() ? "Click the first point in the image. Esc ends measuring."
                               : "Click the second point. Esc ends measuring.");
    return;
  }
  const glm::vec3 from = app::position_world(measured[0], c.shown.poses),
                  to = app::position_world(measured[1], c.shown.poses);
  show_vector(c.ui, "To", to);
  show_vector(c.ui, "Along", to - from);
  c.ui.hint("Components along the world's x, y and z");
  char distance[32];
  std::snprintf(distance, sizeof distance, "%.5g m", static_cast<double>(glm::distance(from, to)));
  show_text(c.ui, "Distance", distance);
}

}  // namespace

glm::vec3 without_rounding(glm::vec3 vector) {
  const glm::vec3 sizes = glm::abs(vector);
  const float least = 1e-6f * std::max({sizes.x, sizes.y, sizes.z});
  for (int axis = 0; axis < 3; ++axis) {
    if (sizes[axis] < least) vector[axis] = 0;
  }
  return vector;
}

void draw_measure_panel(const Context& c) {
  if (!c.ui.header("Measure", c.layout.is_open(Panel::measure))) return;
  app::ViewState& view_state = c.view_state;
  if (c.ui.button("Distance", true, "Between two points that you click in the image  (M)",
                  view_state.measures)) {
    view_state.measures = !view_state.measures;
    view_state.measured.clear();
  }
  c.ui.same_line();
  if (c.ui.button("Clear##measure", !view_state.measured.empty(), "Removes both points"))
    view_state.measured.clear();
  if (view_state.measures) return show_distance(c);
  if (!view_state.picked_point) return c.ui.note("Click a surface for its coordinates.");
  const app::SurfacePoint& point = *view_state.picked_point;
  show_vector(c.ui, "Point", app::position_world(point, c.shown.poses));
  if (point.node < c.shown.scene.nodes.size()) {
    show_vector(c.ui, "In node", point.position_node);
    c.ui.hint("In the frame of the node, before its scale");
  }
}

}  // namespace fire3dv::gui
