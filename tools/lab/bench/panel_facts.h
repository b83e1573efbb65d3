// Synthetic panel contents of a busy session, for measurements and tests without a simulator. Equal image
// numbers give equal contents.
#pragma once

#include "renderer/gui/panel_data.h"

namespace fire3dv::bench {

gui::Facts panel_facts(uint64_t image, glm::uvec2 extent_px);

}  // namespace fire3dv::bench
