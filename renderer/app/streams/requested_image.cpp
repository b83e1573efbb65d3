#include "renderer/app/streams/requested_image.h"

#include <cstring>

#include "protocol/base/error.h"

namespace fire3dv::app {
namespace {

constexpr uint32_t kBoxes2dBit = 7, kBoxes3dBit = 8;
static_assert(1u << kBoxes2dBit == wire::kBoxes2d && 1u << kBoxes3dBit == wire::kBoxes3d);
// The planes follow the colour output, in the order of their bits.
constexpr uint32_t bit_of(passes::Plane plane) {
  return 1 + static_cast<uint32_t>(plane);
}
static_assert(1u << bit_of(passes::Plane::color_linear_f16) == wire::kColorLinearF16);
static_assert(1u << bit_of(passes::Plane::depth_f32) == wire::kDepthF32);
static_assert(1u << bit_of(passes::Plane::instance_u32) == wire::kInstanceU32);
static_assert(1u << bit_of(passes::Plane::semantic_u32) == wire::kSemanticU32);
static_assert(1u << bit_of(passes::Plane::normal_f16) == wire::kNormal);
static_assert(1u << bit_of(passes::Plane::motion_f32) == wire::kMotion);

bool wants(uint32_t bits, uint32_t bit) {
  return (bits >> bit & 1) != 0;
}

std::vector<uint32_t> numbers_of(std::span<const uint8_t> bytes) {
  std::vector<uint32_t> numbers(bytes.size() / sizeof(uint32_t));
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(uint32_t));
  return numbers;
}

template <typename Record>
std::span<const uint8_t> bytes_of(const std::vector<Record>& records) {
  return {reinterpret_cast<const uint8_t*>(records.data()), records.size() * sizeof(Record)};
}

}  // namespace

passes::ImageOutputs outputs_of(uint32_t bits) {
  passes::ImageOutputs outputs;
  outputs.color_srgb8 = wants(bits, 0);
  for (size_t plane = 0; plane < passes::kPlaneCount; ++plane)
    outputs.planes[plane] = wants(bits, bit_of(static_cast<passes::Plane>(plane)));
  outputs.boxes2d = wants(bits, kBoxes2dBit);
  outputs.boxes3d = wants(bits, kBoxes3dBit);
  return outputs;
}

uint32_t bits_of(const passes::ImageOutputs& outputs) {
  uint32_t bits = 0;
  if (outputs.color_srgb8) bits |= wire::kColorSrgb8;
  for (size_t plane = 0; plane < passes::kPlaneCount; ++plane) {
    if (outputs.planes[plane]) bits |= 1u << bit_of(static_cast<passes::Plane>(plane));
  }
  if (outputs.boxes2d) bits |= wire::kBoxes2d;
  if (outputs.boxes3d) bits |= wire::kBoxes3d;
  return bits;
}

RequestedImage::RequestedImage(const ReadbackViews& taken, uint32_t view, uint32_t bits,
                               std::span<const uint8_t> bytes) {
  const size_t pixels = size_t{taken.width} * taken.height;
  const size_t color_bytes = taken.color_srgb8 ? 4 * pixels : 0;
  if (wants(bits, 0)) add(0, taken.width, taken.height, bytes.subspan(view * color_bytes, color_bytes));
  const std::span<const uint8_t> planes = bytes.subspan(taken.views * color_bytes);
  std::span<const uint8_t> instances;
  for (const passes::PlanePlace& place : taken.places) {
    const size_t size = passes::format_of(place.plane).pixel_bytes * pixels;
    const std::span<const uint8_t> plane = planes.subspan(place.offset_bytes + view * size, size);
    if (place.plane == passes::Plane::instance_u32) instances = plane;
    if (wants(bits, bit_of(place.plane))) add(bit_of(place.plane), taken.width, taken.height, plane);
  }
  add_boxes(taken, bits, instances);
}

void RequestedImage::add(uint32_t bit, uint32_t width, uint32_t height, std::span<const uint8_t> bytes) {
  wire::ImagePlane plane;
  plane.output_bit = bit;
  plane.format = wire::format_of_output(bit);
  plane.width = width;
  plane.height = height;
  plane.row_stride = width * static_cast<uint32_t>(wire::bytes_per_element(plane.format));
  plane.offset = end_;
  plane.bytes = bytes.size();
  FIRE3DV_ASSERT(plane.bytes == uint64_t{plane.row_stride} * height);
  pieces_.push_back({plane, bytes});
  end_ += (bytes.size() + 63) / 64 * 64;
}

void RequestedImage::add_boxes(const ReadbackViews& taken, uint32_t bits,
                               std::span<const uint8_t> instances) {
  if ((bits & (wire::kBoxes2d | wire::kBoxes3d)) == 0) return;
  FIRE3DV_ASSERT(taken.boxes);
  const std::vector<passes::Box2d> seen =
      passes::boxes_in_image(numbers_of(instances), taken.width, *taken.boxes);
  if (wants(bits, kBoxes2dBit)) {
    for (const passes::Box2d& b : seen)
      boxes2d_.push_back({b.instance, b.semantic, b.min_x, b.min_y, b.max_x, b.max_y, b.pixels, 0});
    add(kBoxes2dBit, static_cast<uint32_t>(boxes2d_.size()), 1, bytes_of(boxes2d_));
  }
  if (wants(bits, kBoxes3dBit)) {
    for (const passes::Box3d& b : passes::seen_boxes(*taken.boxes, seen))
      boxes3d_.push_back({b.instance, b.semantic, b.world_from_box, {0, 0}});
    add(kBoxes3dBit, static_cast<uint32_t>(boxes3d_.size()), 1, bytes_of(boxes3d_));
  }
}

void RequestedImage::describe_to(wire::ImageFrame& frame) const {
  frame.planes.clear();
  for (const Piece& piece : pieces_) frame.planes.push_back(piece.plane);
  frame.pixel_bytes = end_;
}

void RequestedImage::copy_to(std::span<std::byte> pixels) const {
  FIRE3DV_ASSERT(pixels.size() == end_);
  for (size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    const size_t next = i + 1 < pieces_.size() ? pieces_[i + 1].plane.offset : end_;
    const size_t filled = piece.plane.offset + piece.bytes.size();
    if (!piece.bytes.empty())
      std::memcpy(pixels.data() + piece.plane.offset, piece.bytes.data(), piece.bytes.size());
    std::memset(pixels.data() + filled, 0, next - filled);
  }
}

}  // namespace fire3dv::app
