// Question about the unsaved edits of an earlier run.
#include <cmath>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {

void draw_recovery(const Context& context, const Rect& image) {
  if (!context.shown.editing || context.shown.editing->recovered.empty()) return;
  Ui& ui = context.ui;
  app::Commands& commands = context.view_state.commands;
  ImGui::SetNextWindowPos({std::round((image.low.x + image.high.x) / 2), image.low.y + ui.points(8)},
                          ImGuiCond_Always, {0.5f, 0});
  constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                      ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_AlwaysAutoResize |
                                      ImGuiWindowFlags_NoFocusOnAppearing;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {ui.points(8), ui.points(8)});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, ui.points(4));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1);
  ImGui::PushStyleColor(ImGuiCol_Border, theme::palette->warning);
  if (ImGui::Begin("recovery", nullptr, kFlags)) {
    ui.enter("Recovery");
    ImGui::TextUnformatted(context.shown.editing->recovered.c_str());
    if (ui.button("Apply##recovery", true, "As one step, which Ctrl+Z takes back")) commands.recover = true;
    ui.same_line();
    if (ui.button("Discard##recovery", true, "Removes their file")) commands.recover = false;
  }
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(3);
}

}  // namespace fire3dv::gui
