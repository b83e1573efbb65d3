#include "renderer/gui/scalar_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <vector>

namespace fire3dv::gui {
namespace {

// An apostrophe goes before what spreadsheets take for a formula: titles come from simulators.
std::string quoted(const std::string& text) {
  const bool is_formula =
      !text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos;
  std::string result = is_formula ? "\"'" : "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + '"';
}

void append(std::string& text, double value) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text.append(digits.data(), end);
}

// Seconds with nine decimals, exactly.
void append_seconds(std::string& text, int64_t ns) {
  constexpr uint64_t kPerSecond = 1'000'000'000;
  const uint64_t magnitude = ns < 0 ? 0 - static_cast<uint64_t>(ns) : static_cast<uint64_t>(ns);
  std::array<char, 40> digits{};
  std::snprintf(digits.data(), digits.size(), "%s%llu.%09llu", ns < 0 ? "-" : "",
                static_cast<unsigned long long>(magnitude / kPerSecond),
                static_cast<unsigned long long>(magnitude % kPerSecond));
  text += digits.data();
}

}  // namespace

std::string csv_text(std::span<const ScalarColumn> columns, int64_t begin_ns, int64_t end_ns) {
  std::string text = "sim_time_s";
  std::vector<size_t> next;  // sample of each column that the next row may have
  for (const ScalarColumn& column : columns) {
    const std::string& unit = column.group->declared().units[column.scalar];
    text += "," + quoted(unit.empty() ? column.name : column.name + " [" + unit + "]");
    next.push_back(column.group->find(begin_ns));
  }
  text += "\r\n";
  for (;;) {
    bool has_row = false;
    int64_t time_ns = end_ns;
    for (size_t i = 0; i < columns.size(); ++i) {
      const stream::ScalarGroup& group = *columns[i].group;
      if (next[i] == group.size() || group.sim_time_ns(next[i]) > time_ns) continue;
      time_ns = group.sim_time_ns(next[i]);
      has_row = true;
    }
    if (!has_row) return text;
    append_seconds(text, time_ns);
    for (size_t i = 0; i < columns.size(); ++i) {
      const stream::ScalarGroup& group = *columns[i].group;
      text += ',';
      if (next[i] == group.size() || group.sim_time_ns(next[i]) != time_ns) continue;
      if (const double value = group.value(next[i]++, columns[i].scalar); std::isfinite(value))
        append(text, value);
    }
    text += "\r\n";
  }
}

}  // namespace fire3dv::gui
