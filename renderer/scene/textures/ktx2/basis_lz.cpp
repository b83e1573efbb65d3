#include "renderer/scene/textures/ktx2/basis_lz.h"

#include <cstring>
#include <optional>

#include "renderer/scene/textures/ktx2/etc1s_slice.h"

namespace fire3dv::scene::ktx2 {
namespace {

constexpr size_t kBasisHeaderBytes = 20, kImageBytes = 20;
constexpr uint32_t kIsPFrame = 2;

struct ImageDescription {
  uint32_t flags, color_offset, color_length, alpha_offset, alpha_length;
};
static_assert(sizeof(ImageDescription) == kImageBytes);

struct GlobalData {
  uint16_t endpoint_count = 0, selector_count = 0;
  ImageDescription image{};  // level 0
  std::span<const std::byte> endpoints, selectors, tables;
};

std::optional<GlobalData> read_global_data(std::span<const std::byte> bytes, uint32_t level_count) {
  const size_t first = kBasisHeaderBytes + kImageBytes * level_count;
  if (bytes.size() < first) return std::nullopt;
  GlobalData data;
  std::array<uint32_t, 4> lengths{};  // endpoints, selectors, tables, extended
  std::memcpy(&data.endpoint_count, bytes.data(), 2);
  std::memcpy(&data.selector_count, bytes.data() + 2, 2);
  std::memcpy(lengths.data(), bytes.data() + 4, sizeof lengths);
  std::memcpy(&data.image, bytes.data() + kBasisHeaderBytes, sizeof data.image);
  const uint64_t whole = uint64_t{lengths[0]} + lengths[1] + lengths[2];
  if (whole > bytes.size() - first) return std::nullopt;
  data.endpoints = bytes.subspan(first, lengths[0]);
  data.selectors = bytes.subspan(first + lengths[0], lengths[1]);
  data.tables = bytes.subspan(first + lengths[0] + lengths[1], lengths[2]);
  return data;
}

uint8_t wrapped(uint8_t previous, uint32_t delta, uint32_t mask) {
  return static_cast<uint8_t>((previous + delta) & mask);
}

// Codebook of endpoints: differences from the previous one, with a code for each third of the range.
std::optional<std::vector<Etc1sEndpoint>> read_endpoints(std::span<const std::byte> bytes, uint16_t count) {
  BitReader reader(bytes);
  std::array<std::optional<HuffmanCode>, 3> color_codes;
  for (std::optional<HuffmanCode>& code : color_codes) {
    code = HuffmanCode::read(reader);
    if (!code) return std::nullopt;
  }
  const std::optional<HuffmanCode> intensity_code = HuffmanCode::read(reader);
  if (!intensity_code) return std::nullopt;
  const uint32_t coded_channels = reader.bits(1) == 1 ? 1 : 3;  // 1: grey
  std::vector<Etc1sEndpoint> endpoints(count);
  Etc1sEndpoint previous{{16, 16, 16}, 0};
  for (Etc1sEndpoint& endpoint : endpoints) {
    const auto intensity = intensity_code->decode(reader);
    if (!intensity) return std::nullopt;
    endpoint.intensity = wrapped(previous.intensity, *intensity, 7);
    for (size_t c = 0; c < coded_channels; ++c) {
      const uint8_t value = previous.color5[c];
      const auto delta = color_codes[value < 10 ? 0 : value < 22 ? 1 : 2]->decode(reader);
      if (!delta) return std::nullopt;
      endpoint.color5[c] = wrapped(value, *delta, 31);
    }
    if (coded_channels == 1) endpoint.color5[1] = endpoint.color5[2] = endpoint.color5[0];
    previous = endpoint;
  }
  return endpoints;
}

// Codebook of selectors: raw, or as exclusive-or with the previous one.
std::optional<std::vector<Etc1sSelector>> read_selectors(std::span<const std::byte> bytes, uint16_t count) {
  BitReader reader(bytes);
  if (reader.bits(2) != 0) return std::nullopt;
  const bool is_raw = reader.bits(1) == 1;
  std::optional<HuffmanCode> code;
  if (!is_raw) {
    code = HuffmanCode::read(reader);
    if (!code) return std::nullopt;
  }
  std::vector<Etc1sSelector> selectors(count);
  for (size_t i = 0; i < selectors.size(); ++i) {
    for (size_t y = 0; y < 4; ++y) {
      uint32_t row = 0;
      if (is_raw || i == 0) {
        row = reader.bits(8);
      } else if (const auto delta = code->decode(reader)) {
        row = *delta ^ selectors[i - 1].rows[y];
      } else {
        return std::nullopt;
      }
      selectors[i].rows[y] = static_cast<uint8_t>(row);
    }
    if (reader.is_past_end()) return std::nullopt;
  }
  return selectors;
}

std::optional<SliceCodes> read_codes(std::span<const std::byte> bytes) {
  BitReader reader(bytes);
  SliceCodes codes;
  for (HuffmanCode* code : {&codes.prediction, &codes.endpoint_delta, &codes.selector, &codes.history_run}) {
    auto read = HuffmanCode::read(reader);
    if (!read) return std::nullopt;
    *code = std::move(*read);
  }
  codes.history_size = reader.bits(13);
  if (reader.is_past_end()) return std::nullopt;
  return codes;
}

}  // namespace

Result<Etc1sImage> decode_basis_lz(std::span<const std::byte> global_data, std::span<const std::byte> level,
                                   uint32_t columns, uint32_t rows, uint32_t level_count, bool has_alpha) {
  const Error kDamaged{"its BasisLZ data is damaged"};
  const auto data = read_global_data(global_data, level_count);
  if (!data) return kDamaged;
  if ((data->image.flags & kIsPFrame) != 0) return Error{"its first image is a P frame of an animation"};
  const auto endpoints = read_endpoints(data->endpoints, data->endpoint_count);
  const auto selectors = read_selectors(data->selectors, data->selector_count);
  const auto codes = read_codes(data->tables);
  if (!endpoints || !selectors || !codes) return kDamaged;
  const auto slice = [&](uint32_t offset, uint32_t length) -> std::optional<std::vector<Etc1sBlock>> {
    if (offset > level.size() || length > level.size() - offset) return std::nullopt;
    return decode_slice(level.subspan(offset, length), *codes, *endpoints, *selectors, columns, rows);
  };
  auto color = slice(data->image.color_offset, data->image.color_length);
  if (!color) return kDamaged;
  Etc1sImage image{std::move(*color), {}};
  if (!has_alpha) return image;
  auto alpha = slice(data->image.alpha_offset, data->image.alpha_length);
  if (!alpha) return kDamaged;
  image.alpha = std::move(*alpha);
  return image;
}

}  // namespace fire3dv::scene::ktx2
