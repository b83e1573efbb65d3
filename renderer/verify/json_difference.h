// First difference of JSON values.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

namespace fire3dv::verify {

// Longest text that parse_json() accepts: values take about 16 times as much memory.
constexpr size_t kMaxParsedBytes = 32 << 20;

// stored: untrusted. nullopt: no JSON, nested too deep, or too long.
std::optional<nlohmann::json> parse_json(std::span<const uint8_t> text);

// `field "annotations[3].bbox[2]" is 31 in the file and 30 here`: members of objects by name, elements of
// lists from 0. Lists of different lengths and the same beginning are told by their lengths. nullopt: the
// values are equal.
std::optional<std::string> json_difference(const nlohmann::json& stored, const nlohmann::json& drawn);

}  // namespace fire3dv::verify
