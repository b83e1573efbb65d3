// Pre-parse checks of a glTF file: container lengths and JSON nesting depth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "protocol/base/error.h"

namespace fire3dv::scene {

struct Container {
  std::string_view json;
  std::span<const std::byte> binary;  // BIN chunk of a GLB
  bool has_binary = false;
};

// A GLB is detected by its magic, independent of the file name; other files are JSON.
Result<Container> split_container(std::span<const std::byte> file);

// Upper bound on the number of JSON values, without parsing. Fails above max_depth, since JSON parsers and
// printers recurse.
Result<uint64_t> count_json_values(std::string_view json, uint32_t max_depth);

}  // namespace fire3dv::scene
