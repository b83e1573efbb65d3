// Silhouettes of instances drawn alone, from the bits that the GPU wrote.
#pragma once

#include <cstdint>
#include <span>

#include "renderer/sinks/frame.h"

namespace fire3dv::capture {

// An instance with a silhouette. Its index is its slot, see passes/outputs/silhouettes.h.
struct Silhouetted {
  uint32_t instance = 0, semantic = 0;
};

// Records and masks of the instances that have pixels. bits, instance_plane: read back, at any alignment;
// rows of `width` pixels. A pixel that shows an instance belongs to its silhouette.
sinks::Amodal read_silhouettes(std::span<const uint8_t> bits, std::span<const uint8_t> instance_plane,
                               uint32_t width, uint32_t height, std::span<const Silhouetted> slots);

}  // namespace fire3dv::capture
