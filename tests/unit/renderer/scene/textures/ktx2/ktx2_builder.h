// Builder of KTX 2.0 files in memory, by the specification: container, bits and Huffman tables.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/scene/textures/image_codecs.h"

namespace fire3dv::scene::ktx2_test {

// Writer of bits from the least significant one of each byte upwards.
class BitWriter {
 public:
  void bits(uint32_t value, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i, ++at_) {
      if (at_ % 8 == 0) bytes_.push_back(std::byte{0});
      bytes_.back() |= static_cast<std::byte>((value >> i & 1) << (at_ % 8));
    }
  }
  // Codes of Huffman begin with their highest bit.
  void code(uint32_t value, uint32_t count) {
    for (uint32_t i = count; i-- > 0;) bits(value >> i & 1, 1);
  }
  // A symbol of the code of lengths that table_head() writes: 0 .. 10 have 4 bits, 11 .. 20 have 5.
  void length_symbol(uint32_t symbol) { code(symbol < 11 ? symbol : symbol + 11, symbol < 11 ? 4 : 5); }
  void table_head(uint32_t symbol_count) {
    bits(symbol_count, 14);
    bits(21, 5);
    for (const uint32_t symbol : {17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16})
      bits(symbol < 11 ? 4 : 5, 3);
  }
  // A code whose symbols all have `length` bits: the code of a symbol is its number.
  void uniform_table(uint32_t symbol_count, uint32_t length) {
    table_head(symbol_count);
    for (uint32_t i = 0; i < symbol_count; ++i) length_symbol(length);
  }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
  size_t at_ = 0;
};

struct Ktx2Builder {
  uint32_t format = 0;  // VkFormat
  uint32_t width = 4, height = 4, depth = 0, layers = 0, faces = 1, levels = 1, scheme = 0;
  uint8_t model = 1, transfer = 1, flags = 0;
  std::vector<uint8_t> channels{0};  // of the samples
  std::vector<std::pair<std::string, std::string>> pairs;
  std::vector<std::byte> global_data, level;

  std::vector<std::byte> file() const {
    std::vector<std::byte> descriptor;
    const auto add = [](std::vector<std::byte>& to, const auto& value) {
      const auto* from = reinterpret_cast<const std::byte*>(&value);
      to.insert(to.end(), from, from + sizeof value);
    };
    add(descriptor, static_cast<uint32_t>(28 + 16 * channels.size()));
    add(descriptor, uint32_t{0});
    add(descriptor, static_cast<uint32_t>(2 | (24 + 16 * channels.size()) << 16));
    for (const uint8_t byte : {model, uint8_t{1}, transfer, flags}) add(descriptor, byte);
    for (int i = 0; i < 3; ++i) add(descriptor, uint32_t{0});
    for (const uint8_t channel : channels) {
      add(descriptor, static_cast<uint32_t>(channel << 24));
      for (int i = 0; i < 3; ++i) add(descriptor, uint32_t{0});
    }
    std::vector<std::byte> values;
    for (const auto& [key, value] : pairs) {
      const std::string pair = key + '\0' + value + '\0';
      add(values, static_cast<uint32_t>(pair.size()));
      for (const char c : pair) values.push_back(static_cast<std::byte>(c));
      while (values.size() % 4 != 0) values.push_back(std::byte{0});
    }
    const auto descriptor_at = static_cast<uint32_t>(80 + 24 * levels);
    const auto values_at = static_cast<uint32_t>(descriptor_at + descriptor.size());
    const uint64_t global_at = values_at + values.size(), level_at = global_at + global_data.size();
    std::vector<std::byte> bytes;
    for (const char c : std::string("\xABKTX 20\xBB\r\n\x1A\n")) bytes.push_back(static_cast<std::byte>(c));
    for (const uint32_t word :
         {format, uint32_t{1}, width, height, depth, layers, faces, levels, scheme, descriptor_at,
          static_cast<uint32_t>(descriptor.size()), values_at, static_cast<uint32_t>(values.size())})
      add(bytes, word);
    add(bytes, global_at);
    add(bytes, static_cast<uint64_t>(global_data.size()));
    for (uint32_t i = 0; i < levels; ++i) {
      add(bytes, level_at);
      add(bytes, static_cast<uint64_t>(level.size()));
      add(bytes, uint64_t{0});
    }
    for (const std::vector<std::byte>* part :
         std::initializer_list<const std::vector<std::byte>*>{&descriptor, &values, &global_data, &level})
      bytes.insert(bytes.end(), part->begin(), part->end());
    return bytes;
  }
};

inline Result<Image> decoded(std::span<const std::byte> bytes) {
  const Result<ImageHeader> header = read_image_header(bytes);
  if (!header) return header.error();
  return decode_image(*header, bytes);
}

inline std::vector<uint8_t> texels_of(const Image& image) {
  return {image.rgba8.begin(), image.rgba8.end()};
}

// FNV-1a, for comparisons with pixels of another decoder.
inline uint64_t checksum(std::span<const uint8_t> bytes) {
  uint64_t hash = 0xcbf29ce484222325;
  for (const uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3;
  return hash;
}

// Decodes every truncation of the file, and the file with every bit flipped. Returns how many were refused;
// the others have as many bytes as their size says.
template <typename Expect>
size_t count_refused_damages(const std::vector<std::byte>& good, const Expect& expect) {
  size_t refused = 0;
  const auto decode = [&](std::span<const std::byte> bytes) {
    const Result<ImageHeader> header = read_image_header(bytes);
    if (!header || header->pixels() > 1u << 20) {
      ++refused;
      return;
    }
    const Result<Image> image = decode_image(*header, bytes);
    refused += !image;
    expect(!image || image->rgba8.size() == size_t{4} * image->width * image->height);
  };
  for (size_t size = 0; size < good.size(); ++size) decode(std::span(good).first(size));
  for (size_t i = 0; i < good.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::vector<std::byte> bytes = good;
      bytes[i] ^= static_cast<std::byte>(1 << bit);
      decode(bytes);
    }
  }
  return refused;
}

}  // namespace fire3dv::scene::ktx2_test
