// What is checked of a glTF file before its JSON is parsed: the container's lengths and the depth of the
// JSON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "protocol/error.h"

namespace fire3dv::scene {

struct Container {
  std::string_view json;
  std::span<const std::byte> binary;  // the GLB's BIN chunk
  bool has_binary = false;
};

// A GLB is known by its magic, whatever the file is called; anything else is taken as JSON text.
Result<Container> split_container(std::span<const std::byte> file);

// Counts the values of a JSON text, without parsing it: at most this many are in it. Refuses text that is
// nested deeper than max_depth, since parsers and printers of JSON recurse.
Result<uint64_t> count_json_values(std::string_view json, uint32_t max_depth);

}  // namespace fire3dv::scene
