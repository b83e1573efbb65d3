#include "adapters/ambf/node_table.h"

#include <algorithm>
#include <unordered_set>

#include "protocol/wire/check.h"
#include "protocol/wire/decode.h"

namespace fire3dv::ambf {
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
