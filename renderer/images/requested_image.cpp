#include "renderer/images/requested_image.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "base/error.h"

namespace fire3dv::app {

RequestedImage::RequestedImage(const ReadbackViews& readback, uint32_t view, wire::ImageOutputs outputs,
                               std::span<const uint8_t> bytes) {
  const uint32_t width = readback.width, height = readback.height;
  const size_t pixels = size_t{width} * height;
  const size_t color_bytes = readback.color_srgb8 ? 4 * pixels : 0;
  const std::span<const uint8_t> planes = bytes.subspan(readback.views * color_bytes);
  const auto plane_of = [&](wire::ImageOutput output) -> std::span<const uint8_t> {
    for (const passes::PlaneRange& range : readback.ranges) {
      const size_t size = wire::info_of(output).element_bytes * pixels;
      if (range.output == output) return planes.subspan(range.offset_bytes + view * size, size);
    }
    return {};
  };
  if (outputs.has_boxes()) {
    FIRE3DV_ASSERT(readback.boxes);
    boxes_ = capture::find_visible_boxes(plane_of(wire::kInstanceU32), width, *readback.boxes);
  }
  // The protocol wants them in the order of their bits.
  for (const wire::ImageOutputInfo& info : wire::kImageOutputTable) {
    if (!outputs.has(info.output)) continue;
    if (info.output == wire::kColorSrgb8)
      add(info.output, width, height, bytes.subspan(view * color_bytes, color_bytes));
    else if (info.output == wire::kBoxes2d)
      add_boxes(info.output, boxes_.boxes2d);
    else if (info.output == wire::kBoxes3d)
      add_boxes(info.output, boxes_.boxes3d);
    else
      add(info.output, width, height, plane_of(info.output));
  }
}

void RequestedImage::add(wire::ImageOutput output, uint32_t width, uint32_t height,
                         std::span<const uint8_t> bytes) {
  const wire::ImageOutputInfo& info = wire::info_of(output);
  wire::ImagePlane plane;
  plane.output_bit = static_cast<uint32_t>(std::countr_zero(uint32_t{output}));
  plane.format = info.format;
  plane.width = width;
  plane.height = height;
  plane.row_stride = width * info.element_bytes;
  plane.offset = end_;
  plane.bytes = bytes.size();
  FIRE3DV_ASSERT(plane.bytes == uint64_t{plane.row_stride} * height);
  pieces_.push_back({plane, bytes});
  end_ += (bytes.size() + 63) / 64 * 64;
}

template <typename Record>
void RequestedImage::add_boxes(wire::ImageOutput output, const std::vector<Record>& records) {
  add(output, static_cast<uint32_t>(records.size()), 1,
      {reinterpret_cast<const uint8_t*>(records.data()), records.size() * sizeof(Record)});
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
