#include "protocol/transport/core/note_limiter.h"

#include <algorithm>
#include <utility>

namespace fire3dv::transport {
namespace {

constexpr size_t kMaxSeen = 2 * NoteLimiter::kMaxNotesPerWindow;
constexpr size_t kMaxKeyBytes = 256;

}  // namespace

bool NoteLimiter::allow(std::optional<Cause> cause, const std::string& key, int64_t now_ns) {
  Window& window = windows_[cause ? static_cast<size_t>(*cause) : kCauseCount];
  if (now_ns - window.begins_ns >= kWindowNs) {
    window.begins_ns = now_ns;
    window.shown = 0;
    window.unreported += std::exchange(window.suppressed, 0);
    std::erase_if(window.seen, [&](const Seen& seen) { return now_ns - seen.at_ns >= kWindowNs; });
  }
  const std::string short_key = key.substr(0, kMaxKeyBytes);
  const auto known = std::find_if(window.seen.begin(), window.seen.end(),
                                  [&](const Seen& seen) { return seen.key == short_key; });
  if (known != window.seen.end()) known->at_ns = now_ns;
  if (known != window.seen.end() || window.shown == kMaxNotesPerWindow) {
    ++window.suppressed;
    ++suppressed_;
    return false;
  }
  if (window.seen.size() == kMaxSeen)
    window.seen.erase(std::min_element(window.seen.begin(), window.seen.end(),
                                       [](const Seen& a, const Seen& b) { return a.at_ns < b.at_ns; }));
  window.seen.push_back({short_key, now_ns});
  ++window.shown;
  return true;
}

void NoteLimiter::take_summaries(int64_t now_ns, std::vector<std::string>& summaries) {
  if (suppressed_ == 0) return;
  for (size_t i = 0; i < windows_.size(); ++i) {
    Window& window = windows_[i];
    uint64_t count = std::exchange(window.unreported, 0);
    if (now_ns - window.begins_ns >= kWindowNs) count += std::exchange(window.suppressed, 0);
    if (count == 0) continue;
    const std::string cause =
        i < kCauseCount ? std::string(" (") + cause_name(static_cast<Cause>(i)) + ")" : "";
    summaries.push_back("and " + std::to_string(count) + " more were refused" + cause + " in the last 10 s");
    suppressed_ -= count;
  }
}

}  // namespace fire3dv::transport
