// Frame panel: CPU and GPU times per pass, triangle counts, memory.
#include <algorithm>
#include <cstdio>

#include "renderer/gui/panels.h"

namespace fire3dv::gui {
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
  ui.value("Images", "%.1f /s   %.2f ms", interval_ms > 0 ? 1e3 / static_cast<double>(interval_ms) : 0.0,
           static_cast<double>(interval_ms));
  ui.value("CPU", theme::kAccent, milliseconds(cpu_ms_.median()));
  ui.value("GPU", theme::kSecond, milliseconds(gpu_ms_.median()));
  if (plotted_.empty()) {
    const Ui::Curve curves[] = {{gpu_ms_.values(), theme::kSecond}, {cpu_ms_.values(), theme::kAccent}};
    ui.plot(curves, 54, 0.1f, "ms");
  } else {
    const Ui::Curve curve{pass_ms_[plotted_].values(), theme::kAccent};
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
  ui.value("Image", "%u x %u, %u samples", frame.extent_px.x, frame.extent_px.y, frame.samples);
  ui.value("Device", theme::kText, frame.device);
  ui.value("Drawn", theme::kText, frame.raster);
  ui.value("Shadows", theme::kText, frame.shadows);
}

void FramePanel::draw_passes(const Context& context) {
  Ui& ui = context.ui;
  float most = 1e-3f;
  for (const auto& [name, history] : pass_ms_) most = std::max(most, history.median());
  const float number_width = ui.points(56);
  for (const std::string& name : pass_order_) {
    const float ms = pass_ms_[name].median();
    if (ms < 5e-4f) continue;  // omits negligible passes
    ui.bar(ms / most, theme::rgb(0x24303b));
    const bool is_plotted = plotted_ == name;
    const bool clicked = ui.row(name.c_str(), is_plotted, is_plotted ? theme::kText : theme::kDim);
    ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - number_width);
    ImGui::Text("%6.3f", static_cast<double>(ms));
    if (clicked) plotted_ = is_plotted ? std::string() : name;
  }
}

}  // namespace fire3dv::gui
