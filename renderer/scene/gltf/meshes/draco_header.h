// Header of a Draco mesh stream: the sizes that it states, read before libdraco allocates memory for them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/error.h"

namespace fire3dv::scene {

// Sizes that a stream's header states. `stream` is the input without Draco's metadata, which no renderer
// needs and whose decoder takes quadratic memory.
struct DracoHeader {
  std::vector<std::byte> stream;
  uint64_t faces = 0;
  uint64_t max_points = 0;  // exact in sequential streams, else three per face
  uint32_t seam_attributes = 0;
  bool points_are_exact = false;

  // Upper bound of the decoder's memory, without attributes.
  uint64_t connectivity_bytes() const;
};

Result<DracoHeader> read_draco_header(std::span<const std::byte> stream);

}  // namespace fire3dv::scene
