#include "tools/lab/impair/schedule.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace fire3dv::impair {
namespace {

constexpr double kMostSeconds = 1e6;

std::optional<double> seconds(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  if (!(value >= 0 && value <= kMostSeconds)) return {};
  return value;
}

}  // namespace

std::optional<Outage> parse_outage(const std::string& text) {
  const size_t colon = text.find(':');
  if (colon == std::string::npos) return {};
  const auto at = seconds(std::string_view(text).substr(0, colon));
  const auto length = seconds(std::string_view(text).substr(colon + 1));
  if (!at || !length) return {};
  return Outage{static_cast<int64_t>(*at * 1e9), static_cast<int64_t>((*at + *length) * 1e9)};
}

bool is_down(const std::vector<Outage>& outages, int64_t since_start_ns) {
  return std::any_of(outages.begin(), outages.end(), [&](const Outage& outage) {
    return since_start_ns >= outage.begin_ns && since_start_ns < outage.end_ns;
  });
}

}  // namespace fire3dv::impair
