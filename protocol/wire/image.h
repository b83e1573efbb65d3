// Messages of rendered images on request, and the memory layout of an image. SPEC section 13 is normative.
// Camera frame: -Z forward, +Y up, +X right, as in glTF. Pixels: as in OpenCV, the centre of the upper left
// pixel is (0, 0), x to the right, y down. Metres, radians, nanoseconds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "protocol/wire/affine.h"
#include "protocol/wire/image_outputs.h"
#include "protocol/wire/limits.h"

namespace fire3dv::wire {

enum class LensModel : uint8_t {
  none = 0,
  plumb_bob = 1,  // k1 k2 p1 p2 k3, as in OpenCV
  fisheye = 2,    // k1 k2 k3 k4 0, as in OpenCV's fisheye model
};

struct Lens {
  LensModel model = LensModel::none;
  std::array<float, 5> coefficients{};
  bool operator==(const Lens&) const = default;
};

// Pinhole projection of a camera-space point, before lens distortion: x = fx * X / -Z + cx, y = cy - fy * Y /
// -Z.
struct Intrinsics {
  uint32_t width = 0, height = 0;  // pixels
  float fx = 0, fy = 0;            // pixels; both 0 in a request: the named node's own camera
  float cx = 0, cy = 0;            // pixels; symmetric camera: (width - 1) / 2 and (height - 1) / 2
  float near_m = 0, far_m = 0;     // far 0: infinite
  Lens lens;
  // Thin lens of the colours, both or none. 0 in a request: as the named node's camera and the renderer's
  // settings have it; in an image: a pinhole. The other outputs are those of a pinhole.
  float f_number = 0;          // focal length (24 mm * fy / height) over the diameter of the aperture
  float focus_distance_m = 0;  // along the view direction
  bool operator==(const Intrinsics&) const = default;
};

// Stream frames that an image request selects.
enum class ImageWhen : uint8_t {
  never = 0,      // cancels the request
  once = 1,       // the first displayed frame from `sequence` on
  every_nth = 2,  // the same, and then after every `every` published frames
  rate = 3,       // the same, and then at most rate_hz times a second of the renderer's clock
  exactly = 4,    // exactly the frame `sequence`: lockstep
  batch = 5,      // once, of the poses in ImageRequest::batch
};

// Pinhole projection of one view, in pixels; see Intrinsics.
struct Projection {
  float fx = 0, fy = 0, cx = 0, cy = 0;
  bool operator==(const Projection&) const = default;
};

// Poses of several worlds, which are copies of the scene, and the views that show them. Arrays with one entry
// for all worlds or views have a leading dimension of 1.
struct ImageBatch {
  uint32_t worlds = 1;
  std::vector<uint32_t> node_indices;   // into StreamDescription::node_names, distinct; all others rest
  std::vector<Affine3x4> poses;         // [1 or worlds][node_indices.size()], stream_from_body
  std::vector<uint32_t> world_of_view;  // empty: view v shows world v
  // Replace ImageRequest::parent_from_camera, and fx to cy, of each view. Empty: those of the request.
  std::vector<Affine3x4> view_poses;
  std::vector<Projection> view_projections;
  std::vector<uint8_t> active;  // 1 or 0 by world; empty: all. Pixels of inactive worlds are 0 in all outputs
  bool operator==(const ImageBatch&) const = default;

  uint32_t views() const {
    return world_of_view.empty() ? worlds : static_cast<uint32_t>(world_of_view.size());
  }
  uint32_t world_of(uint32_t view) const { return world_of_view.empty() ? view : world_of_view[view]; }
  bool is_active(uint32_t world) const { return active.empty() || active[world] != 0; }
  std::span<const Affine3x4> poses_of(uint32_t world) const {
    const size_t nodes = node_indices.size();
    return std::span(poses).subspan(poses.size() > nodes ? world * nodes : 0, nodes);
  }
};

// Batch that copies of a request share; null: none.
class SharedImageBatch {
 public:
  SharedImageBatch() = default;
  SharedImageBatch(ImageBatch&& batch) : batch_(std::make_shared<const ImageBatch>(std::move(batch))) {}
  const ImageBatch* get() const { return batch_.get(); }
  const ImageBatch& operator*() const { return *batch_; }
  const ImageBatch* operator->() const { return batch_.get(); }
  explicit operator bool() const { return batch_ != nullptr; }
  bool operator==(const SharedImageBatch& other) const {
    return batch_ == other.batch_ || (batch_ && other.batch_ && *batch_ == *other.batch_);
  }

 private:
  std::shared_ptr<const ImageBatch> batch_;
};

// Adapter to renderer. State whose key is `place`, a slot of the stream: a request replaces the earlier one
// of its slot.
struct ImageRequest {
  uint64_t epoch = 0;  // of the requesting stream
  uint64_t id = 0;     // chosen by the sender, not 0, unique per request
  uint32_t place = 0;  // below kMaxImageRequests
  // Node that carries the camera, resolved like posed nodes; empty: the stream's frame.
  std::string node;
  Affine3x4 parent_from_camera;  // parent: that node, or the stream's frame (as in stream_from_body)
  Intrinsics intrinsics;
  uint32_t outputs = kColorSrgb8;  // ImageOutput bits, see ImageOutputs
  ImageWhen when = ImageWhen::once;
  uint32_t every = 1;      // every_nth: at least 1
  double rate_hz = 0;      // rate: above 0
  uint64_t sequence = 0;   // 0: any. Publishers set their newest sequence: no image is older than its request
  bool markers = false;    // color_srgb8 shows markers of streams
  bool complete = false;   // refused instead of drawn while content of a stream is hidden
  SharedImageBatch batch;  // with ImageWhen::batch, and only then
  bool operator==(const ImageRequest&) const = default;

  uint32_t views() const { return batch ? batch->views() : 1; }
};

// Plane of one output: rows from the top, of row_stride bytes each. Of a batch, the rows of all views in
// their order, without padding.
struct ImagePlane {
  uint32_t output_bit = 0;  // bit number in ImageOutput
  ImageFormat format = ImageFormat::rgba8;
  uint32_t width = 0, height = 0;  // elements; boxes: their number, and 1
  uint32_t row_stride = 0;         // bytes
  uint64_t offset = 0, bytes = 0;  // in the image's pixels; offset is a multiple of 64
  bool operator==(const ImagePlane&) const = default;
};

// Renderer to adapter: header of an image. The pixels follow it (ImageBlock), because a header must be copied
// for validation and pixels need not be.
struct ImageFrame {
  uint64_t request = 0;   // id
  uint64_t number = 0;    // ordinal of the image in this request, from 1; gaps are lost images
  uint64_t epoch = 0;     // the displayed frame of the requesting stream ...
  uint64_t sequence = 0;  // ... 0: it had published none
  int64_t sim_time_ns = 0;
  Affine3x4 world_from_camera;     // rigid: cameras have no scale
  Intrinsics intrinsics;           // as rendered; fx and fy are never 0
  uint64_t pixel_bytes = 0;        // sum over all planes
  std::vector<ImagePlane> planes;  // in the order of their bits
  uint32_t hidden_streams = 0;     // number of streams whose content the image lacks
  // Of a batch: number of its views. The planes have the rows of all; camera and projection are those of the
  // first active view.
  uint32_t views = 1;
  bool operator==(const ImageFrame&) const = default;
};

enum class ImageRefusal : uint8_t {
  unknown_camera = 1,  // no such node, or neither the node nor the request has intrinsics
  not_supported = 2,   // unsupported outputs or lens
  too_large = 3,
  too_many = 4,     // limit of requests per stream
  no_way_back = 5,  // the link does not carry images
  overtaken = 6,    // the requested sequence is no longer displayed
  bad_request = 7,  // invalid values
  hidden = 8,       // a complete image was requested, and content of a stream is hidden
};
constexpr uint8_t kImageRefusalCount = 8;  // numbered from 1

// Renderer to adapter: refusal or end of this request.
struct ImageRefused {
  uint64_t epoch = 0;
  uint64_t request = 0;
  ImageRefusal reason = ImageRefusal::bad_request;
  std::string message;  // for the user, one line
  bool operator==(const ImageRefused&) const = default;
};

constexpr uint32_t kMaxRequestedImageSide = 8192;  // pixels
constexpr uint32_t kMaxBatchWorlds = 65'535;
constexpr uint32_t kMaxBatchViews = 65'536;
constexpr uint32_t kMaxImageRequests = 4096;  // per stream
// Limit of one image: with its header it fits the largest message.
constexpr uint64_t kMaxPixelBytes = kMaxMessageBytes - 4096;

// Memory layout of an image, in network messages and in shared memory: request, header (an encoded
// ImageFrame), pixels. The header can be read without a copy of the pixels.
//
//   0  u64  request     links queue the newest image of each
//   8  u32  head bytes  12  u32  0
//  16  head | zeros up to a multiple of 64 | pixels
constexpr size_t kImageBlockHeaderBytes = 16;
// Upper bound of a header: 9 planes and the other fields.
constexpr size_t kMaxImageHeadBytes = 1024;

constexpr size_t pixels_at(size_t head_bytes) {
  return (kImageBlockHeaderBytes + head_bytes + 63) / 64 * 64;
}
// Sufficient for any header.
constexpr size_t max_block_bytes(size_t pixel_bytes) {
  return pixels_at(kMaxImageHeadBytes) + pixel_bytes;
}

// Writes everything except the pixels; `block` has at least pixels_at(head.size()) bytes.
void write_image_block_head(std::span<std::byte> block, uint64_t request, std::span<const std::byte> head);

struct ImageBlock {
  uint64_t request = 0;
  std::span<const std::byte> head, pixels;
};
// Views of `block`, consistent and inside `block` even while another process writes to it. The caller must
// decode the header from a private copy and validate it against the number of pixel bytes.
Result<ImageBlock> read_image_block(std::span<const std::byte> block);

}  // namespace fire3dv::wire
