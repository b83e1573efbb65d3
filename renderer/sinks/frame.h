// Finished image with its provenance, and the sink interface that consumes it. A sink takes frames in order,
// on one thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/wire/image_outputs.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::sinks {

// Plane other than colours for displays: rows without padding, the top one first.
struct FramePlane {
  wire::ImageOutput output;
  std::vector<uint8_t> bytes;
};

// Silhouettes of instances drawn alone, sorted by instance. masks: of each record, rows from the top, 8
// pixels a byte, the left one in the highest bit (numpy.packbits).
struct Amodal {
  std::vector<wire::AmodalRecord> records;
  std::vector<uint8_t> masks;
};

// Flow to another image of the camera: of each pixel, how far right and down (in pixels) that image shows the
// point that is visible here, and its occlusion there (0 seen, 1 hidden, 2 outside). Motion is NaN behind the
// camera and of nodes that are hidden there. Without another image: NaN, and 2.
struct Flow {
  std::vector<float> motion_px;  // x, y
  std::vector<uint8_t> occlusion;
  static constexpr uint8_t kSeen = 0, kHidden = 1, kOutside = 2;
};

// Settings of a path-traced image.
struct PathTraced {
  uint32_t samples_per_pixel = 0, bounces = 0, seed = 0;
  bool operator==(const PathTraced&) const = default;
};

struct FrameImage {
  uint32_t width = 0, height = 0;
  // sRGB-encoded, top row first, width * height * 4 bytes; empty if only planes were requested.
  std::vector<uint8_t> rgba8;
  std::vector<FramePlane> planes;
  std::optional<std::vector<wire::BoxRecord2d>> boxes2d;  // nullopt: not requested
  std::optional<std::vector<wire::BoxRecord3d>> boxes3d;
  std::optional<Amodal> amodal;
  std::optional<Flow> flow_forward, flow_backward;  // to a later and an earlier image; nullopt: not requested
  uint64_t frame_index = 0;                         // of this run of the renderer, from 0
  std::string camera;
  std::vector<state::FrameTag> shown;                 // empty: the scene is at rest
  std::optional<PathTraced> path_traced;              // nullopt: raster
  std::shared_ptr<const std::string> run_provenance;  // see encode_provenance(); null: none
  // Streams whose content the image lacks, since it takes too much drawing time.
  std::vector<std::string> hidden_streams;
};

class FrameSink {
 public:
  virtual ~FrameSink() = default;

  // May block while the sink writes earlier frames; that delays the renderer, never a simulator. An error is
  // returned once, by the next call; afterwards the sink drops all frames.
  virtual Result<void> consume(FrameImage&& image) = 0;

  // Returns when all frames are written. No frame may follow.
  virtual Result<void> finish() = 0;
};

// Memory of an image's pixels and labels, as far as it grows with its size.
inline uint64_t memory_bytes(const FrameImage& image) {
  uint64_t bytes = image.rgba8.size();
  for (const FramePlane& plane : image.planes) bytes += plane.bytes.size();
  if (image.amodal)
    bytes += image.amodal->masks.size() + image.amodal->records.size() * sizeof(wire::AmodalRecord);
  for (const std::optional<Flow>* const flow : {&image.flow_forward, &image.flow_backward}) {
    if (*flow) bytes += (*flow)->motion_px.size() * sizeof(float) + (*flow)->occlusion.size();
  }
  return bytes;
}

// False for an image whose byte count contradicts its size, which is a bug of the renderer.
inline bool is_consistent(const FrameImage& image) {
  const bool has_others = !image.planes.empty() || image.boxes2d || image.boxes3d || image.amodal;
  return image.rgba8.size() == size_t{4} * image.width * image.height || (image.rgba8.empty() && has_others);
}

// Sink that drops all frames. For benchmarks, and for runs that only show a window.
class NullSink final : public FrameSink {
 public:
  Result<void> consume(FrameImage&&) override {
    ++frames_consumed_;
    return {};
  }
  Result<void> finish() override { return {}; }
  uint64_t frames_consumed() const { return frames_consumed_; }

 private:
  uint64_t frames_consumed_ = 0;
};

}  // namespace fire3dv::sinks
