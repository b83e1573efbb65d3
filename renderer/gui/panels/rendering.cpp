// Panels that change the appearance: lights, materials, and render (draw settings and debug views).

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include "renderer/gui/panels.h"
#include "renderer/gui/screenshot_size.h"
#include "renderer/settings/setting_table.h"

namespace fire3dv::gui {

// --- lights panel: live editing of lights ---

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
  if (light.type == scene::LightType::point)
    changed |= ui.slider("Spread", light.spread, {0, 20, "%.2f"},
                         "Falls off around the node's -Z as exp(-spread (1 - cos)); 0: even");
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
    const auto edited = context.view_state.edits.lights.find(lights[i].node);
    const bool is_of_this =
        edited != context.view_state.edits.lights.end() && edited->second.type == lights[i].light.type;
    draw_light(context, lights[i].node, is_of_this ? edited->second : lights[i].light);
  }
  if (lights.size() > kMaxRows) ui.note("and " + grouped(lights.size() - kMaxRows) + " more");
  if (ui.button("Reset all##lights", !context.view_state.edits.lights.empty(),
                "Restores all lights to files and streams"))
    context.view_state.edits.lights.clear();
}

void LightsPanel::draw_light(const Context& context, uint32_t node, const scene::Light& light) {
  Ui& ui = context.ui;
  app::ViewState& view_state = context.view_state;
  ImGui::PushID(static_cast<int>(node));
  const bool edited = view_state.edits.lights.count(node) != 0;
  const std::string text =
      node_label(context.shown.scene, node) + "  " + type_name(light.type) + (edited ? "  *" : "");
  if (ui.row(text.c_str(), open_ == node, edited ? theme::palette->accent : theme::palette->text))
    open_ = open_ == node ? scene::kNone : node;
  if (open_ == node) {
    scene::Light changed = light;
    if (edit(ui, changed)) view_state.edits.lights[node] = changed;
    if (ui.button("Reset##light", view_state.edits.lights.count(node) != 0,
                  "Restores the file's or stream's values"))
      view_state.edits.lights.erase(node);
    ui.same_line();
    if (ui.button("Select##light", view_state.selected != node, "Its node in the scene"))
      view_state.selected = node;
  }
  ImGui::PopID();
}

// --- materials panel: live editing of material factors; textures and alpha modes are fixed by the file ---

namespace {

std::string label_of(const scene::Scene& scene, uint32_t material) {
  const std::string& name = scene.materials[material].name;
  if (!name.empty()) return name;
  return material == 0 ? "(without material)" : "material " + std::to_string(material);
}

constexpr float kMaxEmission = 100;

// Returns true on a change.
bool edit(Ui& ui, scene::Material& m) {
  bool changed = false;
  glm::vec3 base(m.base_color);
  if (ui.color("Base colour", base)) {
    m.base_color = glm::vec4(base, m.base_color.a);
    changed = true;
  }
  if (m.alpha_mode != scene::AlphaMode::opaque) changed |= ui.slider("Alpha", m.base_color.a, {0, 1});
  if (m.alpha_mode == scene::AlphaMode::mask) changed |= ui.slider("Alpha cutoff", m.alpha_cutoff, {0, 1});
  if (!m.unlit) {
    changed |= ui.slider("Metallic", m.metallic, {0, 1});
    changed |= ui.slider("Roughness", m.roughness, {0, 1});
    if (m.normal_texture.texture != scene::kNone)
      changed |= ui.slider("Normal scale", m.normal_scale, {0, 2});
    // Emission is edited as colour and strength, whose product is the glTF factor.
    float strength = std::max({m.emissive.r, m.emissive.g, m.emissive.b});
    glm::vec3 tint = strength > 0 ? m.emissive / strength : glm::vec3(1);
    bool emission = ui.color("Emission", tint);
    if (emission && strength <= 0) strength = 1;
    emission |= ui.slider("Strength", strength, {0, kMaxEmission, "%.2f", true}, "Of the emission");
    if (emission) m.emissive = tint * strength;
    changed |= emission;
  }
  return changed;
}

// Only of files with KHR_materials_variants.
void choose_variant(Ui& ui, const scene::Scene& scene, uint32_t& variant) {
  if (scene.variants.empty()) return;
  std::vector<const char*> names{"default"};
  for (const std::string& name : scene.variants) names.push_back(name.c_str());
  size_t chosen = variant < scene.variants.size() ? variant + 1 : 0;
  if (ui.choice("Variant", chosen, names, "Materials of the whole file"))
    variant = chosen == 0 ? scene::kNone : static_cast<uint32_t>(chosen - 1);
}

}  // namespace

void MaterialsPanel::list(const Context& context) {
  const scene::Scene& scene = context.shown.scene;
  const uint32_t selected = context.view_state.selected;
  const bool same = scene_ == &scene && scene_number_ == context.shown.scene_number &&
                    listed_of_selection_ == of_selection_ && (!of_selection_ || listed_for_ == selected);
  if (same) return;
  scene_ = &scene;
  scene_number_ = context.shown.scene_number;
  listed_of_selection_ = of_selection_;
  listed_for_ = selected;
  std::vector<bool> used(scene.materials.size(), false);
  std::vector<bool> below(scene.nodes.size(), !of_selection_);
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
    const scene::Node& n = scene.nodes[node];
    // Parents precede their children.
    if (node == selected || (n.parent != scene::kNone && below[n.parent])) below[node] = true;
    if (!below[node] || n.mesh == scene::kNone) continue;
    const scene::Mesh& mesh = scene.meshes[n.mesh];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p)
      used[scene.primitives[p].material] = true;
  }
  listed_.clear();
  for (uint32_t material = 0; material < used.size(); ++material) {
    if (used[material]) listed_.push_back(material);
  }
}

void MaterialsPanel::follow(const scene::Scene& scene, uint32_t selected) {
  if (std::exchange(followed_, selected) == selected || selected >= scene.nodes.size()) return;
  std::vector<bool> below(scene.nodes.size(), false);
  below[selected] = true;
  for (uint32_t node = selected; node < scene.nodes.size(); ++node) {
    const scene::Node& n = scene.nodes[node];
    if (node != selected) below[node] = n.parent != scene::kNone && below[n.parent];
    if (!below[node] || n.mesh == scene::kNone || scene.meshes[n.mesh].primitive_count == 0) continue;
    chosen_ = scene.primitives[scene.meshes[n.mesh].first_primitive].material;
    scrolls_to_chosen_ = true;
    return;
  }
}

void MaterialsPanel::draw(const Context& context) {
  Ui& ui = context.ui;
  if (!ui.header("Materials", context.layout.is_open(Panel::materials))) return;
  app::ViewState& view_state = context.view_state;
  const scene::Scene& scene = context.shown.scene;
  follow(scene, view_state.selected);
  choose_variant(ui, scene, view_state.edits.variant);
  ui.check("Of the selection", of_selection_, "Lists those of the selected node and its descendants");
  list(context);
  if (listed_.empty()) {
    ui.note("No surface has any.");
    return;
  }
  if (std::find(listed_.begin(), listed_.end(), chosen_) == listed_.end()) chosen_ = listed_.front();

  constexpr size_t kMaxRows = 6;
  const float row_height = ImGui::GetTextLineHeightWithSpacing();
  const float list_height = row_height * static_cast<float>(std::min(listed_.size(), kMaxRows));
  ImGui::BeginChild("materials", {0, list_height});
  if (std::exchange(scrolls_to_chosen_, false)) {
    const auto row = std::find(listed_.begin(), listed_.end(), chosen_) - listed_.begin();
    const float y = static_cast<float>(row) * row_height, top = ImGui::GetScrollY();
    if (y < top || y + row_height > top + list_height) ImGui::SetScrollY(y);
  }
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(listed_.size()), row_height);
  while (clipper.Step()) {
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const uint32_t material = listed_[static_cast<size_t>(i)];
      ImGui::PushID(static_cast<int>(material));
      const bool edited = view_state.edits.materials.count(material) != 0;
      const std::string text = label_of(scene, material) + (edited ? "  *" : "");
      if (ui.row(text.c_str(), material == chosen_, edited ? theme::palette->accent : theme::palette->text))
        chosen_ = material;
      ImGui::PopID();
    }
  }
  ImGui::EndChild();

  const auto edited = view_state.edits.materials.find(chosen_);
  scene::Material material = scene.materials[chosen_];
  if (edited != view_state.edits.materials.end()) material = scene::with_factors(material, edited->second);
  ImGui::PushID(static_cast<int>(chosen_));
  if (edit(ui, material)) view_state.edits.materials[chosen_] = scene::factors_of(material);
  if (ui.button("Reset##material", view_state.edits.materials.count(chosen_) != 0,
                "Restores the file's values"))
    view_state.edits.materials.erase(chosen_);
  ui.same_line();
  if (ui.button("Reset all##materials", !view_state.edits.materials.empty(),
                "Restores all materials to the file"))
    view_state.edits.materials.clear();
  ImGui::PopID();
}

// --- render panel: draw settings and debug views ---

namespace {

using namespace settings;

// Combo box of an enumeration with values 0, 1, 2, ... in the order of the names.
template <typename Value, size_t count>
void choose(Ui& ui, const char* label, Value& value, const char* const (&names)[count],
            const char* hint = nullptr) {
  size_t chosen = static_cast<size_t>(value);
  if (ui.choice(label, chosen, names, hint)) value = static_cast<Value>(chosen);
}

// Widgets below the controls of a setting, which read more than the settings.
void note_path_progress(const Context& context) {
  if (context.view_state.draw.path && context.facts.frame.paths)
    context.ui.note(path_progress_text(*context.facts.frame.paths));
}

void offer_focus(const Context& context) {
  app::ViewState& view_state = context.view_state;
  if (!view_state.draw.post.lens.is_pinhole() &&
      context.ui.button("Focus on the point", view_state.picked_point.has_value(),
                        "The surface that was clicked last  (Shift F)"))
    view_state.commands.focus_on_point = true;
}

void note_metering(const Context& context) {
  if (context.view_state.draw.post.metered)
    context.ui.note("Exposure is metered in each image (--exposure metered)");
}

constexpr std::pair<std::string_view, void (*)(const Context&)> kCompanions[] = {
    {"render", note_path_progress}, {"focus-distance", offer_focus}, {"exposure", note_metering}};

void draw_setting_group(const Context& context, SettingGroup group) {
  for (const DrawSetting& setting : draw_setting_table()) {
    if (setting.group != group) continue;
    draw_setting_row(context.ui, setting, context.view_state.draw);
    for (const auto& [name, draw] : kCompanions)
      if (name == setting.name) draw(context);
  }
}

void choose_screenshot_size(const Context& context) {
  Ui& ui = context.ui;
  app::ScreenshotSize& size = context.view_state.screenshot_size;
  constexpr const char* kNames[] = {"image", "image x 2", "image x 4", "other"};
  choose(ui, "  size", size.kind, kNames, "Of screenshots, as the image in the window or larger");
  if (size.kind == app::ScreenshotSize::Kind::fixed)
    ui.text("Screenshot size", "width x height, such as 7680x4320", size.fixed_px);
  const Result<glm::uvec2> pixels = screenshot_px(size, context.facts.frame.extent_px);
  if (!pixels) {
    ui.note(pixels.error().message);
  } else if (size.kind != app::ScreenshotSize::Kind::window) {
    ui.value("  pixels", "%u x %u", pixels->x, pixels->y);
  }
}

void draw_control(Ui& ui, const DrawSetting& setting, const SettingControl& control, DrawSettings& draw) {
  switch (control.kind) {
    case ControlKind::check: {
      bool is_set = chosen_index(control, draw) == 0;
      if (ui.check(control.label, is_set, control.hint))
        (void)control.set(control.values[is_set ? 0 : 1], draw);
      return;
    }
    case ControlKind::choice: {
      size_t chosen = chosen_index(control, draw);
      if (ui.choice(control.label, chosen, control.names, control.hint))
        (void)control.set(control.values[chosen], draw);
      return;
    }
    case ControlKind::slider: {
      float value = std::stof(control.text(draw));
      if (ui.slider(control.label, value,
                    {control.least, control.most, control.format, control.is_logarithmic}, control.hint))
        (void)control.set(number_text(setting.kind == SettingKind::count ? std::round(value) : value), draw);
      return;
    }
    case ControlKind::color:
      ui.color(control.label, control.color(draw), control.hint);
  }
}

}  // namespace

void draw_setting_row(Ui& ui, const DrawSetting& setting, DrawSettings& draw) {
  if (!(setting.users & kByWindow)) return;
  ui.begin_disabled(!is_enabled(setting, draw));
  for (const SettingControl& control : setting.controls)
    if (is_shown(setting, control, draw)) draw_control(ui, setting, control, draw);
  ui.end_disabled();
}

void draw_render_panel(const Context& context) {
  Ui& ui = context.ui;
  if (!ui.header("Render", context.layout.is_open(Panel::render))) return;
  app::ViewState& view_state = context.view_state;
  if (ui.button("Screenshot", true, "A PNG file of the image, without panels  (P)"))
    view_state.commands.screenshot = true;
  ui.same_line();
  const bool recording = context.facts.recording_video;
  if (ui.button(recording ? "Stop video##video" : "Video##video", true, "Of all images from now on  (V)",
                recording))
    view_state.commands.toggle_video = true;
  choose_screenshot_size(context);

  const bool traced_paths = view_state.draw.path.has_value();
  draw_setting_group(context, SettingGroup::paths);
  constexpr const char* kViews[] = {"none",     "normals",           "depth", "nodes", "clusters",
                                    "overdraw", "unresolved shadows"};
  choose(ui, "Debug view", view_state.debug_view, kViews, "Shown instead of light");
  if (!context.facts.why_no_debug_views.empty()) ui.note(context.facts.why_no_debug_views);
  ui.check("Grid and axes", view_state.shows_grid, "In the plane y = 0 of the world  (X)");
  ui.check("Camera frusta", view_state.shows_frusta, "Of the scene's cameras  (K)");
  ui.check("Light theme", context.layout.is_light, "Of the panels");
  for (const SettingGroup group :
       {SettingGroup::image, SettingGroup::raster, SettingGroup::environment, SettingGroup::optics})
    draw_setting_group(context, group);
  keep_path_settings(traced_paths, view_state.draw, view_state.paths);
}

}  // namespace fire3dv::gui
