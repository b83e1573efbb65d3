// What panels might be told in a busy hour: for measuring and testing them without a simulator. The same for
// the same image.
#pragma once

#include "renderer/gui/facts.h"

namespace fire3dv::bench {

gui::Facts panel_facts(uint64_t image, glm::uvec2 extent_px);

}  // namespace fire3dv::bench
