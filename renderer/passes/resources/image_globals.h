// Globals of an image as shaders read them, and behind them the word that ends the image's draws early.
// Shaders that draw content declare the same structure.
#pragma once

#include <cstddef>
#include <cstdint>

#include "shaders/shared/types.h"

namespace fire3dv::passes {

struct ImageGlobals {
  gpu_types::Globals globals;
  uint64_t ends_early = 0;  // not 0: draws are left out; see gpu/submission_limits.h
};
static_assert(offsetof(ImageGlobals, ends_early) == (sizeof(gpu_types::Globals) + 7) / 8 * 8);

}  // namespace fire3dv::passes
