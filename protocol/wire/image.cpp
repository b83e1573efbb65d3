#include "protocol/wire/image.h"

#include <iterator>

#include "protocol/base/error.h"

namespace fire3dv::wire {
namespace {

struct OutputKind {
  const char* name;
  ImageFormat format;
};
constexpr OutputKind kOutputs[] = {
    {"color_srgb8", ImageFormat::rgba8}, {"color_linear_f16", ImageFormat::rgba16f},
    {"depth_f32", ImageFormat::r32f},    {"instance_u32", ImageFormat::r32u},
    {"semantic_u32", ImageFormat::r32u}, {"normal", ImageFormat::rgba16f},
    {"motion", ImageFormat::rg32f},      {"boxes2d", ImageFormat::box2d},
    {"boxes3d", ImageFormat::box3d},
};
static_assert(std::size(kOutputs) == kImageOutputCount);

}  // namespace

const char* image_output_name(uint32_t bit) {
  FIRE3DV_ASSERT(bit < kImageOutputCount);
  return kOutputs[bit].name;
}

ImageFormat format_of_output(uint32_t bit) {
  FIRE3DV_ASSERT(bit < kImageOutputCount);
  return kOutputs[bit].format;
}

size_t bytes_per_element(ImageFormat format) {
  constexpr size_t kBytes[] = {4, 8, 4, 4, 8, sizeof(BoxRecord2d), sizeof(BoxRecord3d)};
  static_assert(std::size(kBytes) == kImageFormatCount);
  const auto index = static_cast<size_t>(format) - 1;
  FIRE3DV_ASSERT(index < kImageFormatCount);
  return kBytes[index];
}

uint64_t pixel_bytes_of(uint32_t width, uint32_t height, uint32_t outputs, uint32_t most_boxes) {
  uint64_t bytes = 0;
  for (uint32_t bit = 0; bit < kImageOutputCount; ++bit) {
    if ((outputs >> bit & 1) == 0) continue;
    const ImageFormat format = kOutputs[bit].format;
    const bool is_boxes = format == ImageFormat::box2d || format == ImageFormat::box3d;
    const uint64_t elements = is_boxes ? most_boxes : uint64_t{width} * height;
    bytes += (elements * bytes_per_element(format) + 63) / 64 * 64;
  }
  return bytes;
}

}  // namespace fire3dv::wire
