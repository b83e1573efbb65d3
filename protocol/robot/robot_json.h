// JSON of untrusted files: a document with limits on depth and values, and checked access to its members.
#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "protocol/robot/rigid.h"

namespace fire3dv::robot {

using Json = nlohmann::json;

// Fault of a file, with the JSON path in it. Readers of files convert it to an Error.
struct Fault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string in_quotes(const std::string& name);

// Stores only the member `wanted` of the outermost object; the others are checked for their syntax. Throws
// Fault.
Json parse_json(std::span<const std::byte> text, const char* wanted);

// Null: no object, or no such member.
const Json* member(const Json& object, const char* name);

// Numbers are finite and of at most 1e12 in magnitude, as in poses. json_path: for messages. Throw Fault.
double number_of(const Json& value, const std::string& json_path);
double number_of(const Json& object, const char* name, double otherwise, const std::string& json_path);
// Text of at most 1024 bytes, as in names of nodes.
const std::string& text_of(const Json& object, const char* name, const std::string& json_path);

// Empty: no such member.
template <size_t N>
std::optional<std::array<double, N>> numbers_of(const Json& object, const char* name,
                                                const std::string& json_path) {
  const Json* const value = member(object, name);
  if (!value) return std::nullopt;
  const std::string here = json_path + "." + name;
  if (!value->is_array() || value->size() != N)
    throw Fault(here + " is not a list of " + std::to_string(N) + " numbers");
  std::array<double, N> numbers;
  for (size_t i = 0; i < N; ++i) numbers[i] = number_of((*value)[i], here);
  return numbers;
}

// Of the members translation and rotation, a quaternion of any length but 0.
Transform rigid_of(const Json& object, const std::string& json_path);

}  // namespace fire3dv::robot
