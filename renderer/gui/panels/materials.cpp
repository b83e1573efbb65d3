// Materials panel: live editing of material factors. Textures and alpha modes are fixed by the file.
#include <algorithm>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {
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

}  // namespace

void MaterialsPanel::list(const Context& context) {
  const scene::Scene& scene = context.shown.scene;
  const uint32_t selected = context.viewer.selected;
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

void MaterialsPanel::draw(const Context& context) {
  Ui& ui = context.ui;
  if (!ui.header("Materials", context.layout.is_open(Panel::materials))) return;
  Viewer& viewer = context.viewer;
  const scene::Scene& scene = context.shown.scene;
  ui.check("Of the selection", of_selection_, "Lists those of the selected node and its descendants");
  list(context);
  if (listed_.empty()) {
    ui.note("No surface has any.");
    return;
  }
  if (std::find(listed_.begin(), listed_.end(), chosen_) == listed_.end()) chosen_ = listed_.front();

  constexpr size_t kMaxRows = 6;
  const float row_height = ImGui::GetTextLineHeightWithSpacing();
  ImGui::BeginChild("materials", {0, row_height * static_cast<float>(std::min(listed_.size(), kMaxRows))});
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(listed_.size()), row_height);
  while (clipper.Step()) {
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const uint32_t material = listed_[static_cast<size_t>(i)];
      ImGui::PushID(static_cast<int>(material));
      const bool edited = viewer.materials.count(material) != 0;
      const std::string text = label_of(scene, material) + (edited ? "  *" : "");
      if (ui.row(text.c_str(), material == chosen_, edited ? theme::kAccent : theme::kText))
        chosen_ = material;
      ImGui::PopID();
    }
  }
  ImGui::EndChild();

  const auto edited = viewer.materials.find(chosen_);
  scene::Material material = edited != viewer.materials.end() ? edited->second : scene.materials[chosen_];
  ImGui::PushID(static_cast<int>(chosen_));
  if (edit(ui, material)) viewer.materials[chosen_] = material;
  if (ui.button("Reset##material", viewer.materials.count(chosen_) != 0, "Restores the file's values"))
    viewer.materials.erase(chosen_);
  ui.same_line();
  if (ui.button("Reset all##materials", !viewer.materials.empty(), "Restores all materials to the file"))
    viewer.materials.clear();
  ImGui::PopID();
}

}  // namespace fire3dv::gui
