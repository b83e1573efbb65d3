#include "tools/lab/impair/impairment.h"

#include <algorithm>
#include <cmath>

#include "base/numbers.h"

namespace fire3dv::impair {
namespace {

constexpr int64_t kLongestQueueNs = 200'000'000;

constexpr double kMaxBytes = 1e18;

constexpr double kMaxSeconds = 1e6;

std::optional<double> seconds(std::string_view text) {
  const std::optional<double> value = parse_number<double>(text);
  return value && *value >= 0 && *value <= kMaxSeconds ? value : std::nullopt;
}

}  // namespace

DatagramChannel::Fate DatagramChannel::draw(const Impairment& impairment, size_t bytes, int64_t now_ns) {
  // All numbers are drawn even if unused, so that one option does not change the effect of another.
  const double loss = chance(), twice = chance(), overtakes = chance(), jitter = 2 * chance() - 1;
  if (impairment.down || loss < impairment.loss || (impairment.mtu != 0 && bytes > impairment.mtu)) return {};
  Fate fate;
  fate.due_ns = now_ns;
  if (impairment.bits_per_second != 0) {
    const auto sending_ns = static_cast<int64_t>(bytes * 8 * 1'000'000'000 / impairment.bits_per_second);
    const int64_t sent_ns = std::max(free_at_ns_, now_ns) + sending_ns;
    if (sent_ns - now_ns > kLongestQueueNs) return {};
    fate.due_ns = free_at_ns_ = sent_ns;
  }
  fate.overtakes = overtakes < impairment.reorder;
  if (!fate.overtakes) {
    const auto late_ns = static_cast<int64_t>(jitter * static_cast<double>(impairment.jitter_ns));
    fate.due_ns += std::max<int64_t>(0, impairment.delay_ns + late_ns);
  }
  fate.copies = twice < impairment.duplicate ? 2 : 1;
  return fate;
}

StreamImpairment::StreamImpairment(const Impairment& impairment, uint64_t connection, bool to_target)
    : generator_(impairment.seed * 0x9e3779b97f4a7c15u + 2 * connection + to_target),
      jitter_(generator_()),
      stall_after_bytes_(impairment.stall_after_bytes) {
  if (impairment.reset_after_bytes != 0) until_reset_ = draw_bytes(impairment.reset_after_bytes);
  if (stall_after_bytes_ != 0) until_stall_ = draw_bytes(stall_after_bytes_);
}

uint64_t StreamImpairment::draw_bytes(uint64_t mean) {
  std::exponential_distribution<double> distance(1 / static_cast<double>(mean));
  return static_cast<uint64_t>(std::clamp(distance(generator_), 1.0, kMaxBytes));
}

uint64_t StreamImpairment::quiet_bytes() const {
  return std::min(until_stall_, until_reset_);
}

bool StreamImpairment::pass(uint64_t bytes) {
  if (until_reset_ != UINT64_MAX) until_reset_ -= std::min(bytes, until_reset_);
  if (until_stall_ == UINT64_MAX) return false;
  until_stall_ -= std::min(bytes, until_stall_);
  if (until_stall_ != 0) return false;
  until_stall_ = draw_bytes(stall_after_bytes_);
  return true;
}

int64_t StreamImpairment::delay_ns(const Impairment& impairment) {
  const double way = std::uniform_real_distribution<double>(-1, 1)(jitter_);
  return std::max<int64_t>(
      0, impairment.delay_ns + static_cast<int64_t>(way * static_cast<double>(impairment.jitter_ns)));
}

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
