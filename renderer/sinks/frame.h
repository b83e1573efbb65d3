// A finished image and what it shows, on its way to whoever wants it. A sink takes frames in order, from one
// thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::sinks {

struct FrameImage {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgba8;  // sRGB-encoded, rows from the top, width * height * 4 bytes
  uint64_t frame_index = 0;    // of this run of the renderer, from 0
  std::string camera;
  std::vector<state::FrameTag> shown;  // empty: the scene rests where its file puts it
};

class FrameSink {
 public:
  virtual ~FrameSink() = default;

  // May wait while the sink is busy with earlier frames: this holds back the renderer, never a simulator. An
  // error is told once, by whichever call comes next; after it the sink takes frames and drops them.
  virtual Result<void> take(FrameImage&& image) = 0;

  // Returns when every frame taken is where it belongs. Nothing may be given to the sink after it.
  virtual Result<void> finish() = 0;
};

// Image with a size that its bytes do not have: a fault of ours.
inline bool is_consistent(const FrameImage& image) {
  return image.rgba8.size() == size_t{4} * image.width * image.height;
}

}  // namespace fire3dv::sinks
