#include "renderer/doctor/loader_rules.h"

#include <algorithm>

#include "base/text.h"

namespace fire3dv::doctor {
namespace {

bool matches_entry(std::string_view entry, std::string_view name) {
  const bool any_beginning = entry.starts_with('*');
  if (any_beginning) entry.remove_prefix(1);
  const bool any_end = entry.ends_with('*');
  if (any_end) entry.remove_suffix(1);
  if (entry.empty()) return any_beginning || any_end;
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
  const std::string entries = lower_case(std::string(filter)), lower_name = lower_case(std::string(name));
  for (size_t begin = 0; begin <= entries.size();) {
    const size_t end = std::min(entries.find(',', begin), entries.size());
    if (matches_entry(std::string_view(entries).substr(begin, end - begin), lower_name)) return true;
    begin = end + 1;
  }
  return false;
}

}  // namespace fire3dv::doctor
