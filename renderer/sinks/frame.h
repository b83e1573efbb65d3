// Finished image with its provenance, and the sink interface that consumes it. A sink takes frames in order,
// on one thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::sinks {

// Non-colour output in row-major order, top row first; see renderer/passes/outputs/image_outputs.h.
struct FramePlane {
  std::string name;
  std::string type;       // element type as a NumPy dtype string
  uint32_t channels = 1;  // elements per pixel
  std::vector<uint8_t> bytes;
};

// 2D bounding box of an instance in pixels: min inclusive, max exclusive.
struct FrameBox2d {
  uint32_t instance = 0, semantic = 0;
  uint32_t min_x = 0, min_y = 0, max_x = 0, max_y = 0;
  uint32_t pixels = 0;  // number of visible pixels
  bool operator==(const FrameBox2d&) const = default;
};

// Oriented 3D bounding box: the unit cube from -0.5 to 0.5, transformed by world_from_box.
struct FrameBox3d {
  uint32_t instance = 0, semantic = 0;
  std::array<float, 12> world_from_box{};  // row-major 3x4
};

struct FrameImage {
  uint32_t width = 0, height = 0;
  // sRGB-encoded, top row first, width * height * 4 bytes; empty if only planes were requested.
  std::vector<uint8_t> rgba8;
  std::vector<FramePlane> planes;
  std::optional<std::vector<FrameBox2d>> boxes2d;  // nullopt: not requested
  std::optional<std::vector<FrameBox3d>> boxes3d;
  uint64_t frame_index = 0;  // of this run of the renderer, from 0
  std::string camera;
  std::vector<state::FrameTag> shown;  // empty: the scene is at rest
};

class FrameSink {
 public:
  virtual ~FrameSink() = default;

  // May block while the sink writes earlier frames; that delays the renderer, never a simulator. An error is
  // returned once, by the next call; afterwards the sink drops all frames.
  virtual Result<void> take(FrameImage&& image) = 0;

  // Returns when all frames are written. No frame may be taken afterwards.
  virtual Result<void> finish() = 0;
};

// False for an image whose byte count contradicts its size, which is a bug of the renderer.
inline bool is_consistent(const FrameImage& image) {
  const bool has_others = !image.planes.empty() || image.boxes2d || image.boxes3d;
  return image.rgba8.size() == size_t{4} * image.width * image.height || (image.rgba8.empty() && has_others);
}

}  // namespace fire3dv::sinks
