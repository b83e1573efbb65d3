#include "renderer/offline/frame_times.h"

#include <charconv>
#include <numeric>
#include <optional>

namespace fire3dv::offline {
namespace {

// Limits that keep the products in at_ns() within int64_t.
constexpr int64_t kMaxNumerator = 1'000'000'000, kMaxDenominator = 100'000;

std::optional<int64_t> whole_number(std::string_view text) {
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || text[0] == '-' || error != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

// Parses "29.97" as 2997/100.
std::optional<FrameRate> decimal(const std::string& text) {
  const size_t point = text.find('.');
  if (point == std::string::npos) {
    const auto whole = whole_number(text);
    return whole ? std::optional(FrameRate{*whole, 1}) : std::nullopt;
  }
  const size_t places = text.size() - point - 1;
  const auto digits = whole_number(text.substr(0, point) + text.substr(point + 1));
  if (places == 0 || places > 3 || !digits) return {};
  int64_t scale = 1;
  for (size_t i = 0; i < places; ++i) scale *= 10;
  return FrameRate{*digits, scale};
}

std::optional<FrameRate> fraction(const std::string& text) {
  const size_t slash = text.find('/');
  if (slash == std::string::npos) return decimal(text);
  const auto numerator = whole_number(text.substr(0, slash)),
             denominator = whole_number(text.substr(slash + 1));
  if (!numerator || !denominator) return {};
  return FrameRate{*numerator, *denominator};
}

}  // namespace

Result<FrameRate> parse_frame_rate(const std::string& text) {
  std::optional<FrameRate> rate = fraction(text);
  if (rate && rate->numerator > 0 && rate->denominator > 0) {
    const int64_t common = std::gcd(rate->numerator, rate->denominator);
    rate->numerator /= common;
    rate->denominator /= common;
    if (rate->numerator <= kMaxNumerator && rate->denominator <= kMaxDenominator &&
        rate->numerator / 100'000 <= rate->denominator && rate->denominator / 1000 <= rate->numerator)
      return *rate;
  }
  return Error{"--fps " + text +
               ": must be frames a second from 0.001 to 100000, such as 30, 29.97 or 30000/1001"};
}

std::string to_text(const FrameRate& rate) {
  return std::to_string(rate.numerator) +
         (rate.denominator == 1 ? "" : "/" + std::to_string(rate.denominator));
}

int64_t FrameTimes::at_ns(uint64_t frame) const {
  const auto scaled = static_cast<int64_t>(frame) * rate.denominator;
  return first_ns + scaled / rate.numerator * kSecondNs +
         scaled % rate.numerator * kSecondNs / rate.numerator;
}

Result<FrameTimes> frame_times(int64_t first_ns, int64_t last_ns, const FrameRate& rate) {
  FrameTimes times{first_ns, rate, 0};
  if (last_ns < first_ns) return times;
  const double wanted = static_cast<double>(last_ns - first_ns) * 1e-9 * static_cast<double>(rate.numerator) /
                        static_cast<double>(rate.denominator);
  if (wanted >= static_cast<double>(kMaxFrames))
    return Error{"that would be more than " + std::to_string(kMaxFrames) +
                 " frames: choose a part with --start and --end, or fewer frames a second with --fps"};
  // Last frame not after the end: floating point is exact within one frame.
  times.frames = static_cast<uint64_t>(wanted) + 2;
  while (times.at_ns(times.frames - 1) > last_ns) --times.frames;
  return times;
}

Part part_of(uint64_t frames, uint32_t index, uint32_t count) {
  const uint64_t first = frames * (index - 1) / count, end = frames * index / count;
  return {first, end - first};
}

}  // namespace fire3dv::offline
