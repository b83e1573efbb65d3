// Help over the image: keys and mouse.

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <string>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {

namespace {

struct Line {
  const char* keys;  // null: heading
  const char* does;
};
constexpr Line kCameraLines[] = {
    {nullptr, "Camera"},
    {"left drag", "orbit"},
    {"right or Shift drag", "pan"},
    {"wheel", "zoom to the cursor"},
    {"W A S D  Q E", "fly"},
    {"Ctrl wheel", "faster, slower"},
    {"1 - 9  0", "scene's cameras; free"},
    {"Home  F", "frame all; selection"},
    {"Shift F", "focus clicked point"},
};
constexpr Line kTimelineLines[] = {
    {nullptr, "Timeline"},
    {"Space", "pause, play"},
    {", .", "one frame back, forwards"},
    {"Left Right", "1 s; with Shift 10 s"},
};
constexpr Line kSceneLines[] = {
    {nullptr, "Scene"},
    {"click  Ctrl drag", "select, pull a body"},
    {"H  Shift H", "hide it; show all"},
    {"I  T", "isolate it; follow it"},
    {"M", "measure a distance"},
    {"X  K", "grid, camera frusta"},
    {"Esc", "end the tool; deselect"},
};
constexpr Line kEditLines[] = {
    {nullptr, "Edit"},
    {"G  R  C", "move, rotate, scale it"},
    {"L  Ctrl drag", "local axes; snap"},
    {"Ctrl Z  Ctrl Y", "undo, redo"},
    {"Ctrl S", "save the edits"},
    {"Ctrl Shift S", "export a new .glb"},
    {"Ctrl D  Del", "copy it, remove it"},
};
constexpr Line kWindowLines[] = {
    {nullptr, "Window"},
    {"F1  Ctrl Q", "this help; quit"},
    {"Tab", "panels on and off"},
    {"P  V", "screenshot, video"},
};

void draw_lines(Ui& ui, std::span<const Line> lines, float left_px, float width_px) {
  for (const Line& line : lines) {
    if (!line.keys) {
      ImGui::Dummy({0, ui.points(2)});
      ImGui::SetCursorPosX(left_px);
      ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(theme::palette->accent), "%s", line.does);
      continue;
    }
    ImGui::SetCursorPosX(left_px);
    ImGui::TextUnformatted(line.keys);
    ImGui::SameLine(left_px + ui.points(130));
    ImGui::PushTextWrapPos(left_px + width_px);
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(theme::palette->dim), "%s", line.does);
    ImGui::PopTextWrapPos();
  }
}

}  // namespace

// One column if the window is high enough for it, else two. It scrolls if even these do not fit.
void draw_help(const Context& context) {
  if (!context.view_state.help) return;
  Ui& ui = context.ui;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float padding = ui.points(14), margin = ui.points(8);
  const float row = ImGui::GetTextLineHeightWithSpacing();
  const auto rows =
      static_cast<float>(std::size(kCameraLines) + std::size(kTimelineLines) + std::size(kSceneLines) +
                         std::size(kEditLines) + std::size(kWindowLines) + 5);
  const float column = ui.points(285), gap = ui.points(16);
  const float max_x = std::max(display.x - 2 * margin, 1.0f), max_y = std::max(display.y - 2 * margin, 1.0f);
  const bool is_high = rows * row + 2 * padding + ui.points(40) <= max_y;
  const bool is_split = !is_high && 2 * column + gap + 2 * padding <= max_x;
  const float wanted = (is_split ? 2 * column + gap : column) + 2 * padding;
  ImGui::SetNextWindowPos({std::round(display.x / 2), std::round(display.y / 2)}, ImGuiCond_Always,
                          {0.5f, 0.5f});
  const float width = std::min(wanted, max_x);
  ImGui::SetNextWindowSizeConstraints({width, 1}, {width, max_y});
  constexpr ImGuiWindowFlags kFlags = (ImGuiWindowFlags_NoDecoration & ~ImGuiWindowFlags_NoScrollbar) |
                                      ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                                      ImGuiWindowFlags_AlwaysAutoResize;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {padding, padding});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, ui.points(6));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1);
  if (ImGui::Begin("help", nullptr, kFlags)) {
    ui.enter("Help");
    const ImVec2 top = ImGui::GetCursorPos();
    const float room = ImGui::GetContentRegionAvail().x;
    const float each = is_split ? (room - gap) / 2 : room;
    draw_lines(ui, kCameraLines, top.x, each);
    draw_lines(ui, kSceneLines, top.x, each);
    const float low = ImGui::GetCursorPosY();
    const float right = is_split ? top.x + each + gap : top.x;
    if (is_split) ImGui::SetCursorPosY(top.y);
    draw_lines(ui, kEditLines, right, each);
    draw_lines(ui, kTimelineLines, right, each);
    draw_lines(ui, kWindowLines, right, each);
    ImGui::SetCursorPosY(std::max(low, ImGui::GetCursorPosY()));
    ImGui::Dummy({0, ui.points(4)});
    if (ui.button("Close##help")) context.view_state.help = false;
  }
  ImGui::End();
  ImGui::PopStyleVar(3);
}

void draw_notice(const Context& context, const Rect& image) {
  const Ui& ui = context.ui;
  if (!context.shown.editing || context.shown.editing->notice.empty()) return;
  const std::string& text = context.shown.editing->notice;
  const float padding = ui.points(8), margin = ui.points(8);
  const float room = std::max(image.high.x - image.low.x - 2 * (padding + margin), ui.points(40));
  const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false, room);
  const ImVec2 at{std::round((image.low.x + image.high.x - size.x) / 2), image.low.y + margin + padding};
  ImDrawList* const list = ImGui::GetForegroundDrawList();
  list->AddRectFilled({at.x - padding, at.y - padding}, {at.x + size.x + padding, at.y + size.y + padding},
                      theme::palette->panel, ui.points(4));
  list->AddRect({at.x - padding, at.y - padding}, {at.x + size.x + padding, at.y + size.y + padding},
                theme::palette->warning, ui.points(4));
  list->AddText(ImGui::GetFont(), ImGui::GetFontSize(), at, theme::palette->text, text.c_str(), nullptr,
                room);
}

}  // namespace fire3dv::gui
