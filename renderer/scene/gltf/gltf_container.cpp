#include "renderer/scene/gltf/gltf_container.h"

#include <bit>
#include <cstring>
#include <string>

namespace fire3dv::scene {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF's numbers are read as they are in memory");

constexpr uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr uint32_t kBinChunk = 0x004E4942;   // "BIN\0"
constexpr size_t kHeaderBytes = 12, kChunkHeaderBytes = 8;

uint32_t word_at(std::span<const std::byte> bytes, size_t offset) {
  uint32_t word;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Result<Container> split_container(std::span<const std::byte> file) {
  Container container;
  if (file.size() < 4 || word_at(file, 0) != kMagic) {
    container.json = as_text(file);
    if (container.json.starts_with("\xEF\xBB\xBF")) container.json.remove_prefix(3);
    return container;
  }
  if (file.size() < kHeaderBytes) return Error{"the GLB header is cut short"};
  if (word_at(file, 4) != 2)
    return Error{"GLB version " + std::to_string(word_at(file, 4)) + " is not supported: only 2 is"};
  const size_t length = word_at(file, 8);
  if (length > file.size() || length < kHeaderBytes) {
    return Error{"the GLB header states " + std::to_string(length) + " bytes, but the file holds " +
                 std::to_string(file.size())};
  }
  for (size_t offset = kHeaderBytes, chunk = 0; offset < length; ++chunk) {
    const std::string name = "GLB chunk " + std::to_string(chunk);
    if (length - offset < kChunkHeaderBytes) return Error{name + " is cut short"};
    const size_t chunk_length = word_at(file, offset);
    const uint32_t type = word_at(file, offset + 4);
    offset += kChunkHeaderBytes;
    if (chunk_length > length - offset) {
      return Error{name + " states " + std::to_string(chunk_length) + " bytes, but only " +
                   std::to_string(length - offset) + " follow"};
    }
    const auto data = file.subspan(offset, chunk_length);
    offset += chunk_length;
    if ((chunk == 0) != (type == kJsonChunk))
      return Error{name + (chunk == 0 ? " is not the JSON" : " is a second JSON")};
    if (type == kJsonChunk) container.json = as_text(data);
    if (type == kBinChunk && !container.has_binary) {
      container.binary = data;
      container.has_binary = true;
    }
  }
  if (container.json.empty()) return Error{"the GLB holds no JSON"};
  return container;
}

Result<uint64_t> count_json_values(std::string_view json, uint32_t max_depth) {
  uint32_t depth = 0;
  uint64_t values = 1;
  bool in_string = false;
  for (size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == ',') {
      ++values;
    } else if (c == '{' || c == '[') {
      ++values;
      if (++depth > max_depth)
        return Error{"the JSON is nested deeper than " + std::to_string(max_depth) + " levels"};
    } else if ((c == '}' || c == ']') && depth > 0) {
      --depth;
    }
  }
  return values;
}

}  // namespace fire3dv::scene
