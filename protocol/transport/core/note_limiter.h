// Rate limiter of user notes about rejected peers. Passes 8 distinct notes per cause in 10 s and counts the
// others for a summary. Bounded memory. Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/clock.h"
#include "protocol/transport/link.h"

namespace fire3dv::transport {

class NoteLimiter {
 public:
  static constexpr size_t kMaxNotesPerWindow = 8;
  static constexpr int64_t kWindowNs = 10 * kSecondNs;

  // Returns true if the note is to be shown. `key` is its text without variable parts such as the remote
  // address. A note repeated within the window is only counted.
  bool allow(std::optional<Cause> cause, const std::string& key, int64_t now_ns);

  // True if suppressed notes await a summary.
  bool has_suppressed() const { return suppressed_ != 0; }
  // Appends "and N more were refused (CAUSE) in the last 10 s" for each cause whose window has ended.
  void take_summaries(int64_t now_ns, std::vector<std::string>& summaries);

 private:
  struct Seen {
    std::string key;
    int64_t at_ns;
  };
  struct Window {
    int64_t begins_ns = 0;
    size_t shown = 0;
    uint64_t suppressed = 0;
    uint64_t unreported = 0;  // suppressed in earlier windows
    std::vector<Seen> seen;
  };
  std::array<Window, kCauseCount + 1> windows_;  // by cause; the last one is for notes without a cause
  uint64_t suppressed_ = 0;                      // sum over all windows
};

}  // namespace fire3dv::transport
