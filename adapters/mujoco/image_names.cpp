#include "adapters/mujoco/image_names.h"

#include <charconv>

#include "protocol/wire/image_outputs.h"
#include "renderer/scene/files.h"

namespace fire3dv::mujoco {
namespace {

// Parses "320x240" exactly.
bool parse_size(std::string_view text, uint32_t& width, uint32_t& height) {
  const char* const end = text.data() + text.size();
  const auto [cross, width_error] = std::from_chars(text.data(), end, width);
  if (width_error != std::errc() || cross == end || *cross != 'x') return false;
  const auto [rest, height_error] = std::from_chars(cross + 1, end, height);
  return height_error == std::errc() && rest == end;
}

}  // namespace

Result<uint32_t> image_outputs(std::string_view text) {
  uint32_t bits = 0;
  while (true) {
    const size_t comma = text.find(',');
    const std::string_view name = text.substr(0, comma);
    const wire::ImageOutputInfo* const info = wire::find_image_output(name);
    if (!info)
      return Error{quote(name) +
                   " is none of color, linear, depth, instance, semantic, normal, motion, boxes2d, boxes3d"};
    if (bits & info->output) return Error{quote(name) + " is given twice"};
    bits |= info->output;
    if (comma == text.npos) return bits;
    text.remove_prefix(comma + 1);
  }
}

Result<ImageSpec> image_spec(const std::string& text) {
  constexpr uint32_t kMaxSide = 8192;  // limit of SPEC.md section 13
  ImageSpec spec;
  spec.camera = text;
  const size_t colon = text.rfind(':');
  uint32_t width = 0, height = 0;
  if (colon != text.npos && parse_size(std::string_view(text).substr(colon + 1), width, height)) {
    if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide)
      return Error{quote(text) + ": sides are 1 to " + std::to_string(kMaxSide) + " pixels"};
    spec.camera = text.substr(0, colon);
    spec.width = width;
    spec.height = height;
  }
  if (spec.camera.empty()) return Error{quote(text) + " names no camera"};
  return spec;
}

}  // namespace fire3dv::mujoco
