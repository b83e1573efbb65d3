// Lights panel: live editing of lights.
#include <numbers>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {
namespace {

constexpr float kHalfTurnRad = std::numbers::pi_v<float> / 2;

// Returns true on a change.
bool edit(Ui& ui, scene::Light& light) {
  bool changed = ui.color("Colour", light.color);
  if (light.type == scene::LightType::directional) {
    changed |= ui.slider("Intensity", light.intensity, {0, 100, "%.2f lx", true});
    float degrees = glm::degrees(light.angular_radius_rad);
    if (ui.slider("Angular radius", degrees, {0, 5, "%.2f \u00b0"}, "More than 0 gives soft shadows")) {
      light.angular_radius_rad = glm::radians(degrees);
      changed = true;
    }
  } else {
    changed |= ui.slider("Intensity", light.intensity, {0, 10'000, "%.1f cd", true});
    changed |= ui.slider("Range", light.range_m, {0, 1'000, "%.2f m", true}, "0: without end");
    changed |= ui.slider("Radius", light.radius_m, {0, 2, "%.3f m"}, "More than 0 gives soft shadows");
  }
  if (light.type == scene::LightType::spot) {
    float inner = glm::degrees(light.inner_cone_rad), outer = glm::degrees(light.outer_cone_rad);
    if (ui.slider("Inner cone", inner, {0, 89, "%.1f \u00b0"})) {
      light.inner_cone_rad = glm::radians(inner);
      light.outer_cone_rad =
          glm::min(glm::max(light.outer_cone_rad, light.inner_cone_rad + glm::radians(0.5f)), kHalfTurnRad);
      changed = true;
    }
    if (ui.slider("Outer cone", outer, {1, 90, "%.1f \u00b0"})) {
      light.outer_cone_rad = glm::radians(outer);
      light.inner_cone_rad =
          glm::max(glm::min(light.inner_cone_rad, light.outer_cone_rad - glm::radians(0.5f)), 0.0f);
      changed = true;
    }
  }
  changed |= ui.check("Casts shadows", light.casts_shadow);
  return changed;
}

const char* type_name(scene::LightType type) {
  constexpr const char* kNames[] = {"sun", "point", "spot"};
  return kNames[static_cast<size_t>(type)];
}

}  // namespace

void LightsPanel::draw(const Context& context) {
  Ui& ui = context.ui;
  if (!ui.header("Lights", context.layout.is_open(Panel::lights))) return;
  const std::vector<scene::PlacedLight> lights = scene::lights_of(context.shown.scene, context.shown.edits);
  if (lights.empty()) {
    ui.note("The scene has no lights: the environment lights it.");
    return;
  }
  constexpr size_t kMaxRows = 64;  // row limit for scrolling
  for (size_t i = 0; i < lights.size() && i < kMaxRows; ++i) {
    const auto edited = context.viewer.lights.find(lights[i].node);
    const bool is_of_this =
        edited != context.viewer.lights.end() && edited->second.type == lights[i].light.type;
    draw_light(context, lights[i].node, is_of_this ? edited->second : lights[i].light);
  }
  if (lights.size() > kMaxRows) ui.note("and " + grouped(lights.size() - kMaxRows) + " more");
  if (ui.button("Reset all##lights", !context.viewer.lights.empty(),
                "Restores all lights to files and streams"))
    context.viewer.lights.clear();
}

void LightsPanel::draw_light(const Context& context, uint32_t node, const scene::Light& light) {
  Ui& ui = context.ui;
  Viewer& viewer = context.viewer;
  ImGui::PushID(static_cast<int>(node));
  const bool edited = viewer.lights.count(node) != 0;
  const std::string text =
      node_label(context.shown.scene, node) + "  " + type_name(light.type) + (edited ? "  *" : "");
  if (ui.row(text.c_str(), open_ == node, edited ? theme::kAccent : theme::kText))
    open_ = open_ == node ? scene::kNone : node;
  if (open_ == node) {
    scene::Light changed = light;
    if (edit(ui, changed)) viewer.lights[node] = changed;
    if (ui.button("Reset##light", viewer.lights.count(node) != 0, "Restores the file's or stream's values"))
      viewer.lights.erase(node);
    ui.same_line();
    if (ui.button("Select##light", viewer.selected != node, "Its node in the scene")) viewer.selected = node;
  }
  ImGui::PopID();
}

}  // namespace fire3dv::gui
