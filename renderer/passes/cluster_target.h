// What clusters are drawn into. It is emptied for every fourth drawing only: the two upper bits of each
// depth, which depths from 0 to below 2 leave free, say by which drawing it came. Later ones win against all
// that earlier ones left, and readers take that for nothing.
#pragma once

#include "renderer/gpu/resources.h"
#include "shaders/shared/raster_types.h"

namespace fire3dv::passes {

struct ClusterTarget {
  gpu::Buffer buffer;

  // Before so many bytes of it, from its start, are drawn into, by commands that are submitted.
  void begin(VkDeviceSize bytes) {
    const bool start_over = bytes > clean_bytes_ || generation_ == FIRE3DV_LAST_GENERATION;
    generation_ = start_over ? 0 : generation_ + FIRE3DV_GENERATION;
    if (start_over) clean_bytes_ = bytes;
  }
  // The same, of what has no free bits.
  void begin_empty(VkDeviceSize bytes) {
    generation_ = 0;
    clean_bytes_ = bytes;
  }
  // Whatever it holds, the next drawing finds it empty.
  void forget() { clean_bytes_ = 0; }
  bool must_be_emptied() const { return generation_ == 0; }  // before it is drawn into, as many bytes
  uint32_t generation() const { return generation_; }        // as in the upper bits of its depths

 private:
  uint32_t generation_ = FIRE3DV_LAST_GENERATION;
  VkDeviceSize clean_bytes_ =
      0;  // as many as were emptied last: they hold nothing of later generations than this
};

}  // namespace fire3dv::passes
