// Help overlay: keys and mouse.
#include "renderer/gui/panels.h"

namespace fire3dv::gui {
namespace {

struct Line {
  const char* keys;  // null: heading
  const char* does;
};
constexpr Line kLines[] = {
    {nullptr, "Camera"},
    {"left drag", "orbit"},
    {"right or Shift drag", "pan"},
    {"wheel", "zoom to the cursor"},
    {"W A S D  Q E", "fly"},
    {"Ctrl wheel", "faster, slower"},
    {"1 - 9, 0", "cameras of the scene, the free one"},
    {"Home", "all of the scene"},
    {"F", "all of the selection"},
    {nullptr, "Scene"},
    {"click", "select a body"},
    {"H", "hide it, or show it again"},
    {"Shift H", "show everything"},
    {"I", "isolate it"},
    {"T", "the camera follows it"},
    {"Esc", "select nothing; then close"},
    {nullptr, "Window"},
    {"F1", "this help"},
    {"Tab", "panels on and off"},
    {"P", "screenshot"},
    {"V", "video on and off"},
};

}  // namespace

void draw_help(const Context& context) {
  if (!context.viewer.help) return;
  Ui& ui = context.ui;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({display.x / 2, display.y / 2}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({ui.points(340), 0});
  constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                      ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_AlwaysAutoResize;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {ui.points(18), ui.points(14)});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, ui.points(6));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1);
  if (ImGui::Begin("help", nullptr, kFlags)) {
    ui.enter("Help");
    for (const Line& line : kLines) {
      if (!line.keys) {
        ImGui::Dummy({0, ui.points(2)});
        ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(theme::kAccent), "%s", line.does);
        continue;
      }
      ImGui::TextUnformatted(line.keys);
      ImGui::SameLine(ui.points(140));
      ImGui::TextDisabled("%s", line.does);
    }
    ImGui::Dummy({0, ui.points(4)});
    if (ui.button("Close##help")) context.viewer.help = false;
  }
  ImGui::End();
  ImGui::PopStyleVar(3);
}

}  // namespace fire3dv::gui
