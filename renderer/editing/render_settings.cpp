#include "renderer/editing/render_settings.h"

#include <iterator>
#include <utility>

namespace fire3dv::app {
namespace {

bool is_same(const passes::PathSettings& a, const passes::PathSettings& b) {
  return a.samples_per_pixel == b.samples_per_pixel && a.bounces == b.bounces && a.lens == b.lens;
}

bool is_same(const passes::PostSettings& a, const passes::PostSettings& b) {
  return a.exposure == b.exposure && a.metered == b.metered && a.tone_map == b.tone_map && a.fxaa == b.fxaa &&
         a.bloom == b.bloom && a.lens == b.lens;
}

bool is_same(const passes::Background& a, const passes::Background& b) {
  return a.show_environment == b.show_environment && a.color == b.color && a.zenith == b.zenith;
}

bool is_same(const passes::DrawSettings& a, const passes::DrawSettings& b) {
  return a.raster == b.raster && a.cull == b.cull && a.levels_of_detail == b.levels_of_detail &&
         a.samples == b.samples && a.shadows == b.shadows && a.ray_effects.on == b.ray_effects.on &&
         a.environment_intensity == b.environment_intensity &&
         a.environment_rotation_rad == b.environment_rotation_rad && is_same(a.background, b.background) &&
         is_same(a.post, b.post) && a.path.has_value() == b.path.has_value() &&
         (!a.path || is_same(*a.path, *b.path));
}

}  // namespace

bool have_same_image(const RenderSettings& a, const RenderSettings& b) {
  return is_same(a.draw, b.draw) && is_same(a.paths, b.paths);
}

void RenderSettingsSteps::record(const gui::DocumentState& document, state::EditHistory& history) {
  RenderSettings now{document.draw, document.paths};
  const auto known = values_.find(history.settings());
  if (known == values_.end() || std::exchange(is_restored_, false)) {
    values_.insert_or_assign(history.settings(), std::move(now));
    return;
  }
  if (have_same_image(known->second, now)) return;
  values_.erase(std::next(known), values_.end());  // of undone steps, which end here
  history.record_settings();
  shown_ = history.settings();
  values_.emplace(shown_, std::move(now));
  // Each kept step has one value, beside the first one.
  while (values_.size() > state::EditHistory::kMaxSteps + 1) values_.erase(values_.begin());
}

void RenderSettingsSteps::restore(gui::DocumentState& document, const state::EditHistory& history) {
  if (std::exchange(shown_, history.settings()) == history.settings()) return;
  const auto known = values_.find(shown_);
  if (known == values_.end()) return;
  document.draw = known->second.draw;
  document.paths = known->second.paths;
  is_restored_ = true;
}

}  // namespace fire3dv::app
