#include "adapters/ambf/node_table.h"

#include <algorithm>
#include <array>
#include <unordered_set>

#include "protocol/wire/check.h"
#include "protocol/wire/decode.h"

namespace fire3dv::ambf {
namespace {

using Rows = std::array<float, 12>;
constexpr Rows kSame{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
// Columns are the node's axes in the object's frame: right, up and back of a camera that looks along -X with
// +Y right.
constexpr Rows kCamera{0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0};
// The same half a turn about Z: it shines along +X.
constexpr Rows kLight{0, 0, -1, 0, -1, 0, 0, 0, 0, 1, 0, 0};

const Rows& body_from_node_of(Kind kind) {
  return kind == Kind::camera ? kCamera : kind == Kind::light ? kLight : kSame;
}

}  // namespace

NodeTable::NodeTable(const std::vector<Object>& objects, Options::Names names) {
  const uint32_t limit = wire::DecodeLimits().max_name_bytes;
  std::unordered_set<std::string> taken;
  for (const Object& object : objects) {
    const std::string& name = names == Options::Names::key ? object.key : object.name;
    const auto good = wire::check_text("name", name, limit);
    const char* const reason = name.empty() ? "it has no name"
                               : !good.ok()
                                   ? "no renderer takes a name with such characters or of that length"
                               : !taken.insert(name).second ? "another object has this name"
                                                            : nullptr;
    if (reason) {
      warnings_.push_back("'" + name + "' is left out: " + reason);
      nodes_.emplace_back();
      continue;
    }
    nodes_.emplace_back(names_.size());
    names_.push_back(name);
    const Rows& rows = body_from_node_of(object.kind);
    body_from_node_.insert(body_from_node_.end(), rows.begin(), rows.end());
  }
}

std::optional<size_t> find_parent(const std::vector<Object>& objects, const std::string& name) {
  if (name.empty()) return std::nullopt;
  const auto first = [&](const auto& fits) -> std::optional<size_t> {
    const auto found = std::find_if(objects.begin(), objects.end(), fits);
    if (found == objects.end()) return std::nullopt;
    return static_cast<size_t>(found - objects.begin());
  };
  const auto exact = first([&](const Object& object) { return object.key == name; });
  if (exact) return exact;
  return first([&](const Object& object) { return object.key.find(name) != std::string::npos; });
}

}  // namespace fire3dv::ambf
