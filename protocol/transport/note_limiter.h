// Rate limiter of the notes that tell the user about refused peers. Per cause it lets 8 different notes pass
// in 10 s and counts the others for one summary. Its memory is bounded. Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocol/transport/clock.h"
#include "protocol/transport/link.h"

namespace fire3dv::transport {

class NoteLimiter {
 public:
  static constexpr size_t kMaxNotesPerWindow = 8;
  static constexpr int64_t kWindowNs = 10 * kSecondNs;

  // True: the note is to be shown. `key` is its text without what makes equal notes differ, such as the
  // remote address. A note that was seen less than a window ago is counted, not shown.
  bool allow(std::optional<Cause> cause, const std::string& key, int64_t now_ns);

  // Some note was counted and is not in a summary yet.
  bool has_suppressed() const { return suppressed_ != 0; }
  // Appends "and N more were refused (CAUSE) in the last 10 s" for each cause whose window is over.
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
