#include "protocol/wire/image_outputs.h"

#include <bit>

namespace fire3dv::wire {
namespace {

constexpr bool is_in_bit_order() {
  for (uint32_t bit = 0; bit < kImageOutputCount; ++bit)
    if (kImageOutputTable[bit].output != 1u << bit) return false;
  return true;
}
static_assert(is_in_bit_order());

constexpr ImageOutputs outputs_with_ids() {
  ImageOutputs outputs(0);
  for (const ImageOutputInfo& info : kImageOutputTable)
    if (info.needs_ids) outputs.add(info.output);
  return outputs;
}
static_assert(!ImageOutputs(kAllImageOutputs & ~outputs_with_ids().bits()).has_id_planes());

std::string known_names() {
  std::string names;
  for (const ImageOutputInfo& info : kImageOutputTable) {
    if (!names.empty()) names += info.output == kImageOutputTable.back().output ? " and " : ", ";
    names += info.cli_name;
  }
  return names;
}

}  // namespace

const ImageOutputInfo& info_at(uint32_t bit) {
  FIRE3DV_ASSERT(bit < kImageOutputCount);
  return kImageOutputTable[bit];
}

const ImageOutputInfo& info_of(ImageOutput output) {
  FIRE3DV_ASSERT(std::has_single_bit(uint32_t{output}));
  return info_at(static_cast<uint32_t>(std::countr_zero(uint32_t{output})));
}

const ImageOutputInfo* find_image_output(std::string_view name) {
  for (const ImageOutputInfo& info : kImageOutputTable)
    if (name == info.cli_name || name == info.api_name) return &info;
  return nullptr;
}

Result<ImageOutputs> parse_image_outputs(std::string_view text) {
  ImageOutputs outputs(0);
  while (true) {
    const size_t comma = text.find(',');
    const std::string_view name = text.substr(0, comma);
    const ImageOutputInfo* const info = find_image_output(name);
    if (!info) return Error{"there is no output \"" + std::string(name) + "\": there are " + known_names()};
    if (outputs.has(info->output)) return Error{"\"" + std::string(name) + "\" is named twice"};
    outputs.add(info->output);
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
  }
  return outputs;
}

uint64_t pixel_bytes_of(uint32_t width, uint32_t height, uint32_t outputs, uint32_t max_boxes) {
  uint64_t bytes = 0;
  for (const ImageOutputInfo& info : kImageOutputTable) {
    if ((outputs & info.output) == 0) continue;
    const uint64_t elements = info.is_boxes ? max_boxes : uint64_t{width} * height;
    bytes += (elements * info.element_bytes + 63) / 64 * 64;
  }
  return bytes;
}

}  // namespace fire3dv::wire
