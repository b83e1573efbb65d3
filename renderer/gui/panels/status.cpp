// Panels of the program's state: frame times and log; and the texts of numbers in all panels.

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {

std::string grouped(uint64_t number) {
  std::string text = std::to_string(number);
  for (size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, " ");
  return text;
}

std::string short_number(double number) {
  constexpr const char* kUnits[] = {"", " k", " M", " G"};
  size_t unit = 0;
  while (number >= 999.5 && unit + 1 < std::size(kUnits)) {
    number /= 1000;
    ++unit;
  }
  char text[48];
  std::snprintf(text, sizeof text,
                unit == 0        ? "%.0f%s"
                : number < 99.95 ? "%.1f%s"
                                 : "%.0f%s",
                number, kUnits[unit]);
  return text;
}

std::string bytes_text(uint64_t bytes) {
  constexpr const char* kUnits[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  double number = static_cast<double>(bytes);
  size_t unit = 0;
  while (number >= 1000 && unit + 1 < std::size(kUnits)) {
    number /= 1024;
    ++unit;
  }
  char text[48];
  std::snprintf(text, sizeof text, unit == 0 || number >= 99.95 ? "%.0f %s" : "%.1f %s", number,
                kUnits[unit]);
  return text;
}

std::string path_progress_text(const settings::PathProgress& paths) {
  return grouped(std::min(paths.samples, paths.samples_per_pixel)) + " / " +
         grouped(paths.samples_per_pixel) + " samples";
}

bool contains_no_case(std::string_view text, std::string_view wanted) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  return std::search(text.begin(), text.end(), wanted.begin(), wanted.end(), same) != text.end();
}

std::string node_label(const scene::Scene& scene, uint32_t node) {
  if (node >= scene.nodes.size()) return "-";
  const scene::Node& n = scene.nodes[node];
  if (!n.name.empty()) return n.name;
  const char* kind = n.camera != scene::kNone  ? "camera"
                     : n.light != scene::kNone ? "light"
                     : n.mesh != scene::kNone  ? "mesh"
                                               : "node";
  return std::string(kind) + " " + std::to_string(node);
}

// --- frame panel: CPU and GPU times per pass, triangle counts, memory ---

namespace {

std::string milliseconds(float ms) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f ms", static_cast<double>(ms));
  return text;
}

}  // namespace

void History::add(float value) {
  if (values_.size() == kMaxSamples) values_.erase(values_.begin());
  values_.push_back(value);
}

float History::median() const {
  if (values_.empty()) return 0;
  std::vector<float> sorted = values_;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<ptrdiff_t>(sorted.size() / 2), sorted.end());
  return sorted[sorted.size() / 2];
}

void FramePanel::note(const FrameFacts& facts) {
  if (facts.images == images_) return;
  images_ = facts.images;
  interval_ms_.add(static_cast<float>(facts.interval_ms));
  cpu_ms_.add(static_cast<float>(facts.cpu_ms));
  gpu_ms_.add(static_cast<float>(facts.gpu_ms));
  std::map<std::string_view, double> sums;
  for (const PassFact& pass : facts.passes) {
    sums[pass.name] += pass.ms;
    if (pass_ms_.find(pass.name) != pass_ms_.end()) continue;
    pass_ms_.emplace(pass.name, History());
    pass_order_.push_back(pass.name);
  }
  // Passes that did not run count as 0.
  for (auto& [name, history] : pass_ms_) {
    const auto sum = sums.find(name);
    history.add(sum == sums.end() ? 0 : static_cast<float>(sum->second));
  }
}

void FramePanel::draw(const Context& context) {
  Ui& ui = context.ui;
  if (!ui.header("Frame", context.layout.is_open(Panel::frame))) return;
  const FrameFacts& frame = context.facts.frame;
  const float interval_ms = interval_ms_.median();
  ui.value("Images", interval_ms < 100 ? "%.1f /s   %.1f ms" : "%.1f /s   %.0f ms",
           interval_ms > 0 ? 1e3 / static_cast<double>(interval_ms) : 0.0, static_cast<double>(interval_ms));
  ui.value("CPU", theme::palette->accent, milliseconds(cpu_ms_.median()));
  ui.value("GPU", theme::palette->second, milliseconds(gpu_ms_.median()));
  if (plotted_.empty()) {
    const Ui::Curve curves[] = {{gpu_ms_.values(), theme::palette->second},
                                {cpu_ms_.values(), theme::palette->accent}};
    ui.plot(curves, 54, 0.1f, "ms");
  } else {
    const Ui::Curve curve{pass_ms_[plotted_].values(), theme::palette->accent};
    ui.plot({&curve, 1}, 54, 0.01f, ("ms  " + plotted_).c_str());
  }
  draw_passes(context);
  if (frame.pose_age_ms) ui.value("Pose age", "%.2f ms", *frame.pose_age_ms);
  ui.value("Triangles", "%s", grouped(frame.triangles).c_str());
  if (frame.clusters_drawn && frame.clusters > 0) {
    // Estimate: all clusters except the last of a mesh have about the same number of triangles.
    const double share = static_cast<double>(*frame.clusters_drawn) / static_cast<double>(frame.clusters);
    ui.value("after culling", "\u2248 %s   %.0f %%",
             short_number(static_cast<double>(frame.triangles) * std::min(share, 1.0)).c_str(), share * 100);
    ui.value("Clusters", "%s of %s", grouped(*frame.clusters_drawn).c_str(), grouped(frame.clusters).c_str());
  }
  if (frame.shadow_rays > 0) ui.value("Shadow rays", "%s", grouped(frame.shadow_rays).c_str());
  ui.value("Memory", "%s GPU, %s CPU", bytes_text(frame.gpu_bytes).c_str(),
           bytes_text(frame.resident_bytes).c_str());
  if (frame.paths) {
    ui.value("Image", "%u x %u", frame.extent_px.x, frame.extent_px.y);
    ui.value("Paths", theme::palette->text, path_progress_text(*frame.paths));
  } else {
    ui.value("Image", "%u x %u, %u sample%s", frame.extent_px.x, frame.extent_px.y, frame.samples,
             frame.samples == 1 ? "" : "s");
  }
  ui.value("Device", theme::palette->text, frame.device);
  ui.value("Drawn", theme::palette->text, frame.raster);
  ui.value("Shadows", theme::palette->text, frame.shadows);
}

void FramePanel::draw_passes(const Context& context) {
  Ui& ui = context.ui;
  float most = 1e-3f;
  for (const auto& [name, history] : pass_ms_) most = std::max(most, history.median());
  const float number_width = ui.points(56);
  for (const std::string& name : pass_order_) {
    const float ms = pass_ms_[name].median();
    if (ms < 5e-4f) continue;  // omits negligible passes
    ui.bar(ms / most, theme::palette->bar);
    const bool is_plotted = plotted_ == name;
    const float room = ImGui::GetContentRegionAvail().x - number_width - ui.points(4);
    const bool clicked =
        ui.row(name.c_str(), is_plotted, is_plotted ? theme::palette->text : theme::palette->dim,
               std::max(room, ui.points(20)));
    char number[32];
    std::snprintf(number, sizeof number, "%.3f", static_cast<double>(ms));
    ImGui::SameLine(ImGui::GetWindowContentRegionMax().x -
                    std::min(ImGui::CalcTextSize(number).x + ui.points(4), number_width));
    ImGui::TextUnformatted(number);
    if (clicked) plotted_ = is_plotted ? std::string() : name;
  }
}

// --- log panel: the messages printed to the terminal ---

void LogPanel::draw(const Context& context) {
  Ui& ui = context.ui;
  const Facts& facts = context.facts;
  lines_px_ = 0;
  if (!ui.header("Log", context.layout.is_open(Panel::log))) return;
  // facts.log holds only the newest of all lines.
  const uint64_t first = facts.log_lines - facts.log.size();
  const size_t from = cleared_ > first ? static_cast<size_t>(cleared_ - first) : 0;
  const size_t count = facts.log.size() - std::min(from, facts.log.size());
  const float buttons = ImGui::CalcTextSize("CopyClear").x + ui.points(4 + 4 * 6);
  const ImVec2 back = ImGui::GetCursorPos();
  constexpr float kLeastLinesPt = 40;  // below, the bottom row scrolls
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

  lines_px_ = std::max(std::floor(ImGui::GetContentRegionAvail().y), ui.points(kLeastLinesPt));
  ImGui::BeginChild("lines", {0, lines_px_});
  const bool follows = ImGui::GetScrollY() >= ImGui::GetScrollMaxY() - 1;
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(count), ImGui::GetTextLineHeightWithSpacing());
  while (clipper.Step()) {
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const LogLine& line = facts.log[from + static_cast<size_t>(i)];
      char time[32];
      std::snprintf(time, sizeof time, "%.1f", line.time_s);
      ImGui::SetCursorPosX(std::max(0.0f, ui.points(48) - ImGui::CalcTextSize(time).x));
      ImGui::PushStyleColor(ImGuiCol_Text, theme::palette->faint);
      ImGui::TextUnformatted(time);
      ImGui::PopStyleColor();
      ImGui::SameLine(0, ui.points(8));
      const std::string whole = one_line(line.text);
      const std::string shown = elided(whole, ImGui::GetContentRegionAvail().x);
      ImGui::TextUnformatted(shown.c_str());
      if (shown != whole) ui.hint(whole.c_str());
    }
  }
  if (follows && seen_ != facts.log_lines) ImGui::SetScrollHereY(1);
  seen_ = facts.log_lines;
  ImGui::EndChild();
}

}  // namespace fire3dv::gui
