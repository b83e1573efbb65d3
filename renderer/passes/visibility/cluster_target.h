// Raster target with depth generations: it is cleared for every fourth drawing only. The two top bits of a
// depth, unused by depths in [0, 2), hold the generation. Newer generations win over older ones, and readers
// ignore depths of older generations.
#pragma once

#include "renderer/gpu/resources.h"
#include "shaders/shared/raster_types.h"

namespace fire3dv::passes {

struct ClusterTarget {
  gpu::Buffer buffer;

  // Starts a generation. Call it before submitted commands draw into the first `bytes` of the buffer.
  void begin(VkDeviceSize bytes) {
    const bool start_over = bytes > clean_bytes_ || generation_ == FIRE3DV_LAST_GENERATION;
    generation_ = start_over ? 0 : generation_ + FIRE3DV_GENERATION;
    if (start_over) clean_bytes_ = bytes;
  }
  // The same for a target without generation bits; it is always cleared.
  void begin_empty(VkDeviceSize bytes) {
    generation_ = 0;
    clean_bytes_ = bytes;
  }
  // Invalidates the content; the next drawing clears it.
  void invalidate() { clean_bytes_ = 0; }
  bool needs_clear() const {
    return generation_ == 0;
  }                                                    // before the drawing, as many bytes as begin()
                                                       // got
  uint32_t generation() const { return generation_; }  // as in the top bits of its depths

 private:
  uint32_t generation_ = FIRE3DV_LAST_GENERATION;
  VkDeviceSize clean_bytes_ = 0;  // cleared range: it has no depths of later generations
};

}  // namespace fire3dv::passes
