// Names for errors about a name that nothing has: the nearest existing ones, or some of all.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.h"

namespace fire3dv {

// Number of insertions, deletions, replacements and swaps of neighbours that turn one word into the other.
inline size_t edit_distance(std::string_view from, std::string_view to) {
  std::vector<size_t> before, last, row(to.size() + 1);
  for (size_t j = 0; j < row.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= from.size(); ++i) {
    before = std::exchange(last, row);
    row[0] = i;
    for (size_t j = 1; j <= to.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (from[i - 1] != to[j - 1])});
      if (i > 1 && j > 1 && from[i - 1] == to[j - 2] && from[i - 2] == to[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row.back();
}

// The nearest names first, at most `most`: those within a third of the letters, whatever their case, and
// those of which one contains the other. Empty and very long names are left out.
inline std::vector<std::string> nearest_names(std::string_view wanted, const std::vector<std::string>& known,
                                              size_t most = 3) {
  constexpr size_t kMaxBytes = 200;  // the distance takes the product of both lengths
  constexpr size_t kMaxKnown = 20'000;
  const std::string lower = lower_case(std::string(wanted.substr(0, kMaxBytes)));
  const size_t limit = std::max<size_t>(1, lower.size() / 3);
  std::vector<std::pair<size_t, std::string>> found;
  for (size_t i = 0; i < std::min(known.size(), kMaxKnown); ++i) {
    if (known[i].empty() || known[i].size() > kMaxBytes) continue;
    const std::string other = lower_case(known[i]);
    const bool is_part = lower.size() >= 3 && other.size() >= 3 &&
                         (other.find(lower) != std::string::npos || lower.find(other) != std::string::npos);
    const size_t distance = is_part ? 1 : edit_distance(lower, other);
    if (distance <= limit) found.emplace_back(distance, known[i]);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<std::string> names;
  for (size_t i = 0; i < std::min(found.size(), most); ++i) names.push_back(std::move(found[i].second));
  return names;
}

// End of an error: `; did you mean "arm"?`, or without a near name `; there are "a", "b" and 7 more`. what:
// "nodes", for `; there are no nodes`.
inline std::string name_hint(std::string_view wanted, std::vector<std::string> known, std::string_view what) {
  constexpr size_t kMaxListed = 8;
  std::erase(known, "");
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  if (known.empty()) return "; there are no " + std::string(what);
  const std::vector<std::string> near = nearest_names(wanted, known);
  if (!near.empty()) {
    std::string text = "; did you mean ";
    for (size_t i = 0; i < near.size(); ++i)
      text += (i == 0 ? "" : i + 1 == near.size() ? " or " : ", ") + quote(near[i]);
    return text + "?";
  }
  std::string text = known.size() == 1 ? "; there is " : "; there are ";
  for (size_t i = 0; i < std::min(known.size(), kMaxListed); ++i) text += (i ? ", " : "") + quote(known[i]);
  if (known.size() > kMaxListed) text += " and " + std::to_string(known.size() - kMaxListed) + " more";
  return text;
}

}  // namespace fire3dv
