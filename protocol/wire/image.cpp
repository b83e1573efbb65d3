#include "protocol/wire/image.h"

#include <iterator>

#include "protocol/error.h"

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

}  // namespace fire3dv::wire
