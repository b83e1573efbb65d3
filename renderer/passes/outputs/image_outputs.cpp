#include "renderer/passes/outputs/image_outputs.h"

#include <algorithm>
#include <string>

namespace fire3dv::passes {
namespace {

constexpr PlaneFormat kFormats[kPlaneCount] = {
    {"linear", "<f2", 4, 8},   {"depth", "<f4", 1, 4},  {"instance", "<u4", 1, 4},
    {"semantic", "<u4", 1, 4}, {"normal", "<f2", 4, 8}, {"motion", "<f4", 2, 8},
};
constexpr uint64_t kPlaneAlignment = 64;

// Returns the flag of an output name, or null for an unknown name.
bool* flag_named(ImageOutputs& outputs, std::string_view name) {
  if (name == "color") return &outputs.color_srgb8;
  if (name == "boxes2d") return &outputs.boxes2d;
  if (name == "boxes3d") return &outputs.boxes3d;
  for (size_t i = 0; i < kPlaneCount; ++i) {
    if (name == kFormats[i].name) return &outputs.planes[i];
  }
  return nullptr;
}

std::string known_names() {
  std::string names = "color";
  for (const PlaneFormat& format : kFormats) names += ", " + std::string(format.name);
  return names + ", boxes2d and boxes3d";
}

}  // namespace

const PlaneFormat& format_of(Plane plane) {
  return kFormats[static_cast<size_t>(plane)];
}

bool ImageOutputs::any_plane() const {
  return std::find(planes.begin(), planes.end(), true) != planes.end();
}

bool ImageOutputs::any_surface_plane() const {
  return std::find(planes.begin() + 1, planes.end(), true) != planes.end();
}

ImageOutputs with_sources(ImageOutputs outputs) {
  if (outputs.boxes2d || outputs.boxes3d) outputs[Plane::instance_u32] = true;
  return outputs;
}

Result<ImageOutputs> parse_image_outputs(std::string_view text) {
  ImageOutputs outputs;
  outputs.color_srgb8 = false;
  while (true) {
    const size_t comma = text.find(',');
    const std::string_view name = text.substr(0, comma);
    bool* const flag = flag_named(outputs, name);
    if (!flag) return Error{"there is no output \"" + std::string(name) + "\": there are " + known_names()};
    if (*flag) return Error{"\"" + std::string(name) + "\" is named twice"};
    *flag = true;
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
  }
  return outputs;
}

std::vector<PlanePlace> place_planes(const ImageOutputs& outputs, uint32_t width, uint32_t height) {
  std::vector<PlanePlace> places;
  uint64_t offset = 0;
  for (size_t i = 0; i < kPlaneCount; ++i) {
    if (!outputs.planes[i]) continue;
    const uint64_t size = uint64_t{kFormats[i].pixel_bytes} * width * height;
    places.push_back({static_cast<Plane>(i), offset, size});
    offset = (offset + size + kPlaneAlignment - 1) / kPlaneAlignment * kPlaneAlignment;
  }
  return places;
}

uint64_t bytes_of(std::span<const PlanePlace> places) {
  return places.empty() ? 0 : places.back().offset_bytes + places.back().size_bytes;
}

}  // namespace fire3dv::passes
