#include "renderer/editing/render_settings.h"

#include <iterator>
#include <utility>

#include "renderer/settings/setting_table.h"

namespace fire3dv::app {
bool have_same_image(const RenderSettings& a, const RenderSettings& b) {
  return a.paths == b.paths &&
         settings::have_same_values(a.draw, b.draw, settings::kByWindow | settings::kByBrowser);
}

void RenderSettingsSteps::record(const DocumentState& document, state::EditHistory& history) {
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

void RenderSettingsSteps::restore(DocumentState& document, const state::EditHistory& history) {
  if (std::exchange(shown_, history.settings()) == history.settings()) return;
  const auto known = values_.find(shown_);
  if (known == values_.end()) return;
  document.draw = known->second.draw;
  document.paths = known->second.paths;
  is_restored_ = true;
}

}  // namespace fire3dv::app
