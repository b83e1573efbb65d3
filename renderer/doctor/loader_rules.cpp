#include "renderer/doctor/loader_rules.h"

#include <algorithm>
#include <vector>

#include "base/text.h"
#include "base/words.h"

namespace fire3dv::doctor {
namespace {

bool matches_entry(std::string_view entry, std::string_view name) {
  const bool any_beginning = entry.starts_with('*');
  if (any_beginning) entry.remove_prefix(1);
  const bool any_end = entry.ends_with('*');
  if (any_end) entry.remove_suffix(1);
  if (entry.empty()) return true;  // "*" or "**"
  if (any_beginning && any_end) return name.find(entry) != std::string_view::npos;
  if (any_beginning) return name.ends_with(entry);
  return any_end ? name.starts_with(entry) : name == entry;
}

}  // namespace

std::string version_text(uint32_t version) {
  return std::to_string(version >> 22 & 0x7F) + "." + std::to_string(version >> 12 & 0x3FF) + "." +
         std::to_string(version & 0xFFF);
}

bool matches_filter(std::string_view filter, std::string_view name) {
  const std::string lower_name = lower_case(std::string(name));
  const std::vector<std::string> entries = split(lower_case(std::string(filter)), ",");
  return std::any_of(entries.begin(), entries.end(),
                     [&](const std::string& entry) { return matches_entry(entry, lower_name); });
}

}  // namespace fire3dv::doctor
