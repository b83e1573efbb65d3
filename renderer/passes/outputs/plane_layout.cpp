#include "renderer/passes/outputs/plane_layout.h"

namespace fire3dv::passes {

constexpr uint64_t kPlaneAlignment = 64;

std::vector<PlaneRange> lay_out_planes(const ImageOutputs& outputs, uint32_t width, uint32_t height) {
  std::vector<PlaneRange> places;
  uint64_t offset = 0;
  for (const wire::ImageOutputInfo& info : wire::kImageOutputTable) {
    if (!outputs.has(info.output) || info.output == wire::kColorSrgb8 || info.is_boxes) continue;
    const uint64_t size = uint64_t{info.element_bytes} * width * height;
    places.push_back({info.output, offset, size});
    offset = (offset + size + kPlaneAlignment - 1) / kPlaneAlignment * kPlaneAlignment;
  }
  return places;
}

uint64_t bytes_of(std::span<const PlaneRange> places) {
  return places.empty() ? 0 : places.back().offset_bytes + places.back().size_bytes;
}

}  // namespace fire3dv::passes
