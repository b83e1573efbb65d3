// A finished image and what it shows, on its way to whoever wants it. A sink takes frames in order, from one
// thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::sinks {

// Numbers beside the colour, rows from the top: see renderer/passes/image_outputs.h.
struct FramePlane {
  std::string name;
  std::string type;       // of a number, as NumPy writes it
  uint32_t channels = 1;  // numbers a pixel
  std::vector<uint8_t> bytes;
};

// Around the pixels that show an instance: first inclusive, end exclusive.
struct FrameBox2d {
  uint32_t instance = 0, semantic = 0;
  uint32_t min_x = 0, min_y = 0, max_x = 0, max_y = 0;
  uint32_t pixels = 0;  // that show it
  bool operator==(const FrameBox2d&) const = default;
};

// The cube from -0.5 to 0.5 in each axis, taken by this matrix, holds what the instance shows.
struct FrameBox3d {
  uint32_t instance = 0, semantic = 0;
  std::array<float, 12> world_from_box{};  // by rows
};

struct FrameImage {
  uint32_t width = 0, height = 0;
  // sRGB-encoded, rows from the top, width * height * 4 bytes; empty where only planes were wanted
  std::vector<uint8_t> rgba8;
  std::vector<FramePlane> planes;
  std::optional<std::vector<FrameBox2d>> boxes2d;  // nothing: not wanted
  std::optional<std::vector<FrameBox3d>> boxes3d;
  uint64_t frame_index = 0;  // of this run of the renderer, from 0
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
  const bool has_others = !image.planes.empty() || image.boxes2d || image.boxes3d;
  return image.rgba8.size() == size_t{4} * image.width * image.height || (image.rgba8.empty() && has_others);
}

}  // namespace fire3dv::sinks
