#include "tools/lab/impair/datagram_channel.h"

#include <algorithm>

namespace fire3dv::impair {
namespace {

constexpr int64_t kLongestQueueNs = 200'000'000;

}  // namespace

DatagramChannel::Fate DatagramChannel::draw(const Impairment& impairment, size_t bytes, int64_t now_ns) {
  // All numbers are drawn even if unused, so that one option does not change the effect of another.
  const double loss = chance(), twice = chance(), overtakes = chance(), jitter = 2 * chance() - 1;
  if (impairment.down || loss < impairment.loss) return {};
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

}  // namespace fire3dv::impair
