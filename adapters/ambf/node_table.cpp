#include "adapters/ambf/node_table.h"

#include <algorithm>
#include <map>
#include <unordered_set>

#include "protocol/wire/check.h"
#include "protocol/wire/decode.h"

namespace fire3dv::ambf {

NodeTable::NodeTable(const std::vector<Object>& objects, Options::Names names) {
  const uint32_t limit = wire::DecodeLimits().max_name_bytes;
  std::unordered_set<std::string> taken;
  for (const Object& object : objects) {
    if (object.kind == Kind::soft_body) {
      nodes_.emplace_back();
      continue;
    }
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

std::optional<size_t> find_parent(const std::vector<Object>& objects, const std::vector<size_t>& added,
                                  size_t child, const std::string& name) {
  if (name.empty()) return std::nullopt;
  const auto has_name = [&](size_t object) { return objects[object].key.find(name) != std::string::npos; };
  const auto at_child = std::find(added.begin(), added.end(), child);
  struct Answer {
    std::optional<size_t> exact, part;
    size_t parts = 0;
  };
  std::map<Kind, Answer> answers;
  for (auto it = added.begin(); it != at_child; ++it) {
    if (!has_name(*it)) continue;
    Answer& answer = answers[objects[*it].kind];
    if (objects[*it].key == name) answer.exact = *it;
    answer.part = *it;
    ++answer.parts;
  }
  std::optional<size_t> found;
  size_t kinds = 0;
  for (const auto& [kind, answer] : answers) {
    if (!answer.exact && answer.parts != 1) continue;
    found = answer.exact ? answer.exact : answer.part;
    ++kinds;
  }
  if (kinds == 1) return found;
  if (at_child == added.end()) return std::nullopt;
  const auto later = std::find_if(at_child + 1, added.end(), has_name);
  if (later == added.end()) return std::nullopt;
  return *later;
}

}  // namespace fire3dv::ambf
