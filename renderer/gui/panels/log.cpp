// Log panel: the messages printed to the terminal.
#include <algorithm>
#include <cstdio>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {

void LogPanel::draw(const Context& context) {
  Ui& ui = context.ui;
  const Facts& facts = context.facts;
  if (!ui.header("Log", context.layout.is_open(Panel::log))) return;
  // facts.log holds only the newest of all lines.
  const uint64_t first = facts.log_lines - facts.log.size();
  const size_t from = cleared_ > first ? static_cast<size_t>(cleared_ - first) : 0;
  const size_t count = facts.log.size() - std::min(from, facts.log.size());
  const float buttons = ImGui::CalcTextSize("CopyClear").x + ui.points(4 + 4 * 6);
  const ImVec2 back = ImGui::GetCursorPos();
  ImGui::SetCursorPos(
      {ImGui::GetWindowContentRegionMax().x - buttons, back.y - ImGui::GetTextLineHeight() - ui.points(10)});
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {ui.points(6), ui.points(1)});
  if (ui.button("Copy##log", count > 0, "All of it to the clipboard")) {
    std::string all;
    for (size_t i = from; i < facts.log.size(); ++i) all += facts.log[i].text + "\n";
    ImGui::SetClipboardText(all.c_str());
  }
  ui.same_line();
  if (ui.button("Clear##log", count > 0)) cleared_ = facts.log_lines;
  ImGui::PopStyleVar();
  ImGui::SetCursorPos(back);

  ImGui::BeginChild("lines", {0, 0});
  const bool follows = ImGui::GetScrollY() >= ImGui::GetScrollMaxY() - 1;
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(count), ImGui::GetTextLineHeightWithSpacing());
  while (clipper.Step()) {
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const LogLine& line = facts.log[from + static_cast<size_t>(i)];
      char time[32];
      std::snprintf(time, sizeof time, "%.1f", line.time_s);
      ImGui::SetCursorPosX(std::max(0.0f, ui.points(48) - ImGui::CalcTextSize(time).x));
      ImGui::PushStyleColor(ImGuiCol_Text, theme::kFaint);
      ImGui::TextUnformatted(time);
      ImGui::PopStyleColor();
      ImGui::SameLine(0, ui.points(8));
      ImGui::TextUnformatted(one_line(line.text).c_str());
    }
  }
  if (follows && seen_ != facts.log_lines) ImGui::SetScrollHereY(1);
  seen_ = facts.log_lines;
  ImGui::EndChild();
}

}  // namespace fire3dv::gui
