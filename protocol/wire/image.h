// Images that a simulator asks its renderer for. SPEC section 13 is normative.
// Frames: a camera looks along its -Z, with +Y up and +X to the right, as in glTF. Pixels as OpenCV has them:
// the middle of the upper left pixel is (0, 0), x to the right, y down. Metres, radians, nanoseconds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "protocol/wire/affine.h"

namespace fire3dv::wire {

// What an image holds, as bits of a set. The numbers are the wire's.
enum ImageOutput : uint32_t {
  kColorSrgb8 = 1u << 0,      // finished: tone-mapped, sRGB-encoded; alpha 255
  kColorLinearF16 = 1u << 1,  // linear light, before tone mapping
  kDepthF32 = 1u << 2,        // metres along the camera's axis; infinity where nothing is
  kInstanceU32 = 1u << 3,     // 1 + index of the scene's node; 0 where nothing is
  kSemanticU32 = 1u << 4,     // class of the node; 0: none
  kNormal = 1u << 5,          // of the surface, in the world, of length 1; 0 where nothing is
  kMotion = 1u << 6,          // pixels from where the surface was in this request's image before
  kBoxes2d = 1u << 7,         // BoxRecord2d for each instance that is seen
  kBoxes3d = 1u << 8,         // BoxRecord3d for each instance that is seen
};
constexpr uint32_t kImageOutputCount = 9;
constexpr uint32_t kAllImageOutputs = (1u << kImageOutputCount) - 1;
// "color_srgb8" ... of the output of bit number `bit`.
const char* image_output_name(uint32_t bit);

// How the elements of a plane lie in memory.
enum class ImageFormat : uint8_t {
  rgba8 = 1,
  rgba16f = 2,
  r32f = 3,
  r32u = 4,
  rg32f = 5,
  box2d = 6,
  box3d = 7,
};
constexpr uint8_t kImageFormatCount = 7;  // they count from 1
size_t bytes_per_element(ImageFormat format);
// Which format an output comes in: it has one.
ImageFormat format_of_output(uint32_t bit);

// Around the pixels that show the instance: min inclusive, max exclusive, in whole pixels.
struct BoxRecord2d {
  uint32_t instance, semantic;
  uint32_t min_x, min_y, max_x, max_y;
  uint32_t pixels;  // that show it
  uint32_t reserved;
};
static_assert(sizeof(BoxRecord2d) == 32);

// The cube from -0.5 to 0.5 in each axis, taken by this matrix, holds the node's mesh.
struct BoxRecord3d {
  uint32_t instance, semantic;
  std::array<float, 12> world_from_box;  // row-major
  uint32_t reserved[2];
};
static_assert(sizeof(BoxRecord3d) == 64);

enum class LensModel : uint8_t {
  none = 0,
  plumb_bob = 1,  // k1 k2 p1 p2 k3, as OpenCV has them
  fisheye = 2,    // k1 k2 k3 k4 0, as OpenCV's fisheye has them
};

struct Lens {
  LensModel model = LensModel::none;
  std::array<float, 5> coefficients{};
  bool operator==(const Lens&) const = default;
};

// What projects a point of the camera's frame: x = fx * X / -Z + cx, y = cy - fy * Y / -Z, the lens between.
struct Intrinsics {
  uint32_t width = 0, height = 0;  // pixels
  float fx = 0, fy = 0;            // pixels; both 0 in a request: as the named node's own camera has it
  float cx = 0, cy = 0;            // pixels; of a symmetric camera (width - 1) / 2 and (height - 1) / 2
  float near_m = 0, far_m = 0;     // far 0: infinite
  Lens lens;
  bool operator==(const Intrinsics&) const = default;
};

// Which frames of the stream an image is made of.
enum class ImageWhen : uint8_t {
  never = 0,      // takes the request back
  once = 1,       // the first frame that is shown from `sequence` on
  every_nth = 2,  // that one, and then whenever `every` more frames have been published
  rate = 3,       // that one, and then at most rate_hz times a second of the renderer's clock
  exactly = 4,    // the frame `sequence` and no other: lockstep
};

// Adapter to renderer. A state whose key is its place: a request takes the place of the one that was there.
struct ImageRequest {
  uint64_t epoch = 0;  // of the stream that asks
  uint64_t id = 0;     // the asker's choice, not 0, another one for each request
  uint32_t place = 0;  // below kMostImageRequests
  // The node that carries the camera, found as the nodes that poses move; empty: the stream's own frame.
  std::string node;
  Affine3x4 parent_from_camera;  // parent: that node, or the stream's frame (as stream_from_body)
  Intrinsics intrinsics;
  uint32_t outputs = kColorSrgb8;  // ImageOutput bits
  ImageWhen when = ImageWhen::once;
  uint32_t every = 1;     // every_nth: at least 1
  double rate_hz = 0;     // rate: above 0
  uint64_t sequence = 0;  // 0: any. A publisher gives the newest that it has published, so that an image is
                          // never older than the wish for it
  bool operator==(const ImageRequest&) const = default;
};

// One output of an image: rows from the top, of row_stride bytes each.
struct ImagePlane {
  uint32_t output_bit = 0;  // number of the bit in ImageOutput
  ImageFormat format = ImageFormat::rgba8;
  uint32_t width = 0, height = 0;  // elements; of boxes their number, and 1
  uint32_t row_stride = 0;         // bytes
  uint64_t offset = 0, bytes = 0;  // in the image's pixels; offset is a multiple of 64
  bool operator==(const ImagePlane&) const = default;
};

// Renderer to adapter: the head of an image. The pixels travel behind it (image_block.h), since a head has to
// be copied before it is believed, and pixels need not be.
struct ImageFrame {
  uint64_t request = 0;   // id
  uint64_t number = 0;    // of the images of this request, from 1: what is missing was lost on the way
  uint64_t epoch = 0;     // the frame of the asking stream that the image shows ...
  uint64_t sequence = 0;  // ... 0: it had published none
  int64_t sim_time_ns = 0;
  Affine3x4 world_from_camera;     // a rotation and a place: cameras have no scale
  Intrinsics intrinsics;           // as they were used; fx and fy are never 0
  uint64_t pixel_bytes = 0;        // of all planes
  std::vector<ImagePlane> planes;  // in the order of their bits
  bool operator==(const ImageFrame&) const = default;
};

enum class ImageRefusal : uint8_t {
  unknown_camera = 1,  // no such node, or it has no camera and the request no intrinsics
  not_supported = 2,   // outputs or a lens that this renderer does not make
  too_large = 3,
  too_many = 4,     // requests of this stream
  no_way_back = 5,  // images do not travel over this link
  overtaken = 6,    // the sequence that was asked for is not shown any more
  bad_request = 7,  // values that are not allowed
};
constexpr uint8_t kImageRefusalCount = 7;  // they count from 1

// Renderer to adapter: no image (any more) for this request.
struct ImageRefused {
  uint64_t epoch = 0;
  uint64_t request = 0;
  ImageRefusal reason = ImageRefusal::bad_request;
  std::string message;  // for people, one line
  bool operator==(const ImageRefused&) const = default;
};

constexpr uint32_t kMostImageSide = 8192;                  // pixels
constexpr uint32_t kMostImageRequests = 4096;              // of one stream
// Of one image: with its head it is no longer than any message.
constexpr uint64_t kMostPixelBytes = (uint64_t{256} << 20) - 4096;
// What the planes of a request's outputs take together; of boxes, for so many of them.
uint64_t pixel_bytes_of(uint32_t width, uint32_t height, uint32_t outputs, uint32_t most_boxes);

}  // namespace fire3dv::wire
