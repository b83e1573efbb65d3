#include "renderer/verify/json_difference.h"

#include <algorithm>

#include "base/text.h"

namespace fire3dv::verify {
namespace {

using Json = nlohmann::json;

constexpr size_t kMaxValueBytes = 120;
constexpr int kMaxNesting = 32;  // comparisons and texts of JSON are recursive

std::string text_of(const Json* value) {
  return value ? printable_text(value->dump(), kMaxValueBytes) : std::string("absent");
}

// Null: absent.
const Json* member(const Json& object, const std::string& name) {
  const auto found = object.find(name);
  return found == object.end() ? nullptr : &*found;
}

struct Pair {
  const Json *stored, *drawn;
};

// Replaces the pair by its first members that differ, and adds their name. False: there are none.
bool descend(Pair& pair, std::string& path) {
  const Json &stored = *pair.stored, &drawn = *pair.drawn;
  if (stored.is_object() && drawn.is_object()) {
    for (const Json* const side : {&drawn, &stored}) {
      for (const auto& [name, value] : side->items()) {
        const Json *const before = member(stored, name), *const now = member(drawn, name);
        if (before && now && *before == *now) continue;
        path += (path.empty() ? "" : ".") + printable_text(name, kMaxValueBytes);
        pair = {before, now};
        return true;
      }
    }
    return false;
  }
  if (!stored.is_array() || !drawn.is_array()) return false;
  const auto [before, now] = std::mismatch(stored.begin(), stored.end(), drawn.begin(), drawn.end());
  if (before == stored.end() || now == drawn.end()) return false;
  path += "[" + std::to_string(before - stored.begin()) + "]";
  pair = {&*before, &*now};
  return true;
}

std::string entries(size_t count) {
  return std::to_string(count) + (count == 1 ? " entry" : " entries");
}

}  // namespace

std::optional<Json> parse_json(std::span<const uint8_t> text) {
  if (text.size() > kMaxParsedBytes) return std::nullopt;
  bool is_too_deep = false;
  const auto check_depth = [&](int depth, Json::parse_event_t, Json&) {
    is_too_deep |= depth > kMaxNesting;
    return !is_too_deep;
  };
  Json parsed = Json::parse(text.begin(), text.end(), check_depth, false);
  if (is_too_deep || parsed.is_discarded()) return std::nullopt;
  return parsed;
}

std::optional<std::string> json_difference(const Json& stored, const Json& drawn) {
  if (stored == drawn) return std::nullopt;
  Pair pair{&stored, &drawn};
  std::string path;
  while (pair.stored && pair.drawn && descend(pair, path)) {
  }
  const std::string name = path.empty() ? "the value" : "field \"" + path + "\"";
  if (pair.stored && pair.drawn && pair.stored->is_array() && pair.drawn->is_array())
    return name + " has " + entries(pair.stored->size()) + " in the file and " + entries(pair.drawn->size()) +
           " here";
  return name + " is " + text_of(pair.stored) + " in the file and " + text_of(pair.drawn) + " here";
}

}  // namespace fire3dv::verify
