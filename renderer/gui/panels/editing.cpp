// Panel of the user's edits: the gizmo, the transform of the selected node, undo, redo and the overlay file.

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "renderer/gui/gizmo_overlay.h"
#include "renderer/gui/panels.h"

namespace fire3dv::gui {

namespace {

void draw_history(const Context& context) {
  static const app::EditFacts kNone;
  Ui& ui = context.ui;
  app::Commands& commands = context.view_state.commands;
  const app::EditFacts& facts = context.shown.editing ? *context.shown.editing : kNone;
  const std::string undo = facts.undo.empty() ? "Nothing to undo" : "Restores " + facts.undo + "  (Ctrl+Z)";
  if (ui.button("Undo", !facts.undo.empty(), undo.c_str())) commands.undo = true;
  ui.same_line();
  const std::string redo = facts.redo.empty() ? "Nothing to redo" : "Repeats " + facts.redo + "  (Ctrl+Y)";
  if (ui.button("Redo", !facts.redo.empty(), redo.c_str())) commands.redo = true;
  ui.same_line();
  const std::string save = facts.file.empty() ? "A scene of a recording: start with --overlay FILE"
                                              : "All edits, to " + facts.file + "  (Ctrl+S)";
  if (ui.button(facts.is_saved ? "Save##overlay" : "Save *##overlay", !facts.file.empty(), save.c_str()))
    commands.save_overlay = true;
  ui.same_line();
  if (ui.button("Export", true, "The edited scene, as a new .glb beside the scene  (Ctrl+Shift+S)"))
    commands.export_glb = true;
}

// Objects in front of the view, and files of the offered folders.
void draw_additions(const Context& context) {
  Ui& ui = context.ui;
  app::Commands& commands = context.view_state.commands;
  const auto object = [&](const char* label, app::ObjectKind kind, const char* hint) {
    if (ui.button(label, true, hint)) commands.add = kind;
    if (kind != app::ObjectKind::camera) ui.same_line();
  };
  object("+ Point", app::ObjectKind::point_light, "Adds a point light where the view turns about");
  object("Spot", app::ObjectKind::spot_light, "Adds a spot light there, along the view");
  object("Sun", app::ObjectKind::directional_light, "Adds a directional light along the view");
  object("Camera", app::ObjectKind::camera, "Adds a camera that sees what you see now");
  const app::EditFacts* const facts = context.shown.editing;
  if (!facts) return;
  std::vector<std::string> labels{"choose ..."};
  for (const std::string& asset : facts->assets) labels.push_back(one_line(asset));
  std::vector<const char*> names;
  for (const std::string& label : labels) names.push_back(label.c_str());
  size_t chosen = 0;
  const char* const hint = "Adds a glTF file of the overlay file's folder or of that of --assets";
  const bool is_chosen = ui.choice("Add file", chosen, names, hint) && chosen != 0;
  if (ui.has_opened_list()) commands.list_assets = true;  // files may have come since
  if (is_chosen) commands.add_asset = facts->assets[chosen - 1];
}

// They have no node that could be selected and removed.
void draw_refused(const Context& context) {
  const app::EditFacts* const facts = context.shown.editing;
  for (size_t i = 0; facts && i < facts->refused.size(); ++i) {
    const app::RefusedAddition& refused = facts->refused[i];
    const std::string hint = "Not added: " + one_line(refused.reason);
    context.ui.note(quote(refused.name) + " is not added.");
    if (context.ui.button(("Remove##refused" + std::to_string(i)).c_str(), true, hint.c_str()))
      context.view_state.commands.remove_addition = refused.name;
  }
}

void draw_removal(const Context& context, uint32_t node) {
  if (node >= context.shown.scene.nodes.size()) return;
  context.ui.same_line();
  if (context.ui.button("Copy", true, "Another one of the node and all below it  (Ctrl+D)"))
    context.view_state.commands.duplicate = true;
  context.ui.same_line();
  if (context.ui.button("Remove", true, "The node and all below it, with their lights  (Del)"))
    context.view_state.edits.removed.insert(std::exchange(context.view_state.selected, scene::kNone));
}

void draw_tools(const Context& context) {
  Ui& ui = context.ui;
  app::ViewState& view_state = context.view_state;
  const auto tool = [&](const char* label, app::GizmoTool which, const char* hint) {
    const bool is_on = view_state.tool == which;
    if (ui.button(label, true, hint, is_on)) view_state.tool = is_on ? app::GizmoTool::none : which;
    ui.same_line();
  };
  tool("Move", app::GizmoTool::move, "Handles that move the selected node; Ctrl snaps  (G)");
  tool("Rotate", app::GizmoTool::rotate, "Rings that turn it; Ctrl snaps to 15\u00b0  (R)");
  tool("Scale", app::GizmoTool::scale, "Handles that scale it; Ctrl snaps to tenths  (C)");
  if (ui.button("Local", true, "The handles have the axes of the node, not of the world  (L)",
                view_state.tool_is_local))
    view_state.tool_is_local = !view_state.tool_is_local;
}

// A field of 0 would flatten the node for ever.
void keep_volume(glm::vec3& scale, const glm::vec3& before) {
  constexpr float kLeastScale = 1e-4f;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(scale[axis]) < kLeastScale) scale[axis] = std::copysign(kLeastScale, before[axis]);
  }
}

// The factor that the user has changed changes the others alike.
void keep_ratio(glm::vec3& scale, const glm::vec3& before) {
  for (int axis = 0; axis < 3; ++axis) {
    if (scale[axis] == before[axis] || before[axis] == 0) continue;
    const float changed = scale[axis];
    scale = before * (changed / before[axis]);
    scale[axis] = changed;
    return;
  }
}

void draw_transform(const Context& context, uint32_t node) {
  Ui& ui = context.ui;
  app::ViewState& view_state = context.view_state;
  if (const std::string* const driver = app::direct_driver_of(context.shown.poses, node)) {
    ui.note("Driven by " + one_line(*driver) + ": it cannot be moved by hand meanwhile.");
    return;
  }
  const state::NodeTransform before = shown_transform(context.shown, view_state, node);
  state::NodeTransform now = before;
  if (before.has_shear) {
    glm::vec3 position(before.matrix[3]);
    if (ui.numbers("Position", position, {0.01f, "%.3f"}, "Metres, relative to the parent"))
      now.matrix[3] = glm::vec4(position, 1);
    ui.note("Rotation and scale are one matrix (shear); the gizmo changes them.");
  } else {
    ui.numbers("Position", now.translation, {0.01f, "%.3f"}, "Metres, relative to the parent");
    glm::vec3 degrees = glm::degrees(glm::eulerAngles(before.rotation));
    if (ui.numbers("Rotation", degrees, {0.5f, "%.1f\u00b0"},
                   "About x, y and z of the parent, in this order"))
      now.rotation = glm::normalize(glm::quat(glm::radians(degrees)));
    if (ui.numbers("Scale", now.scale, {0.01f, "%.3f"}, "Along the node's own axes")) {
      keep_volume(now.scale, before.scale);
      if (view_state.scale_is_uniform) keep_ratio(now.scale, before.scale);
    }
    ui.check("Uniform scale", view_state.scale_is_uniform, "A change of one factor changes all three alike");
  }
  if (now != before && state::is_valid(now)) view_state.edits.transforms[node] = now;
  if (view_state.edits.transforms.contains(node) &&
      ui.button("Reset##transform", true, "Restores the transform of the file"))
    view_state.edits.transforms.erase(node);
}

void draw_save_as(const Context& context) {
  std::string& path = context.view_state.save_path;
  context.ui.text("Overlay file", "Path of another overlay file", path);
  if (context.ui.button("Save as", !path.empty(), "All edits, to this overlay file, now and by Ctrl+S"))
    context.view_state.commands.save_as = path;
}

}  // namespace

void draw_edit_panel(const Context& context) {
  if (!context.ui.header("Edit", context.layout.is_open(Panel::edit))) return;
  draw_history(context);
  draw_additions(context);
  draw_refused(context);
  draw_tools(context);
  const uint32_t node = context.view_state.selected;
  draw_removal(context, node);
  if (node < context.shown.scene.nodes.size()) draw_transform(context, node);
  draw_save_as(context);
}

}  // namespace fire3dv::gui
