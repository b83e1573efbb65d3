// Render settings that a user changes while a window is open (panel Render), as steps of the undo history.
// Unlike edits they are no part of an overlay file.
#pragma once

#include <cstdint>
#include <map>

#include "renderer/editing/edit_history.h"
#include "renderer/editing/view_state.h"
#include "renderer/settings/draw_settings.h"

namespace fire3dv::app {

struct RenderSettings {
  settings::DrawSettings draw;
  settings::PathSettings paths;
};
// Compares what panels and browsers can change.
bool have_same_image(const RenderSettings& a, const RenderSettings& b);

// Values of the render settings by the numbers in an edit history.
class RenderSettingsSteps {
 public:
  // Records changed settings as a step. Call after the renderer has taken or reset them: what it resets after
  // restore() is no step.
  void record(const DocumentState& document, state::EditHistory& history);
  // Sets those of the history, after it was undone or redone.
  void restore(DocumentState& document, const state::EditHistory& history);

 private:
  std::map<uint64_t, RenderSettings> values_;
  uint64_t shown_ = 0;
  bool is_restored_ = false;
};

}  // namespace fire3dv::app
