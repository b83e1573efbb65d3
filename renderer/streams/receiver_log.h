// Log messages of the receiver of streams, limited for each peer and in all.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace fire3dv::app {

// Limit of events per second.
struct RateLimit {
  int64_t since_ns = 0;
  uint32_t used = 0;

  bool take(int64_t now_ns, uint32_t per_second) {
    constexpr int64_t kSecondNs = 1'000'000'000;
    if (used == 0 || now_ns - since_ns >= kSecondNs) {
      since_ns = now_ns;
      used = 0;
    }
    if (used == per_second) return false;
    ++used;
    return true;
  }
};

// A peer that reconnects a thousand times a second must neither flood the terminal nor suppress the messages
// of others.
class ReceiverLog {
 public:
  // of_peer: limit of the peer that the message is about; null: none.
  void add(std::string text, RateLimit* of_peer, int64_t now_ns) {
    constexpr uint32_t kPerSecond = 10, kTotalPerSecond = 200;
    if ((of_peer && !of_peer->take(now_ns, kPerSecond)) || !total_.take(now_ns, kTotalPerSecond)) {
      ++suppressed_;
      return;
    }
    if (total_.used == 1 && suppressed_ != 0)
      messages_.push_back("and " + std::to_string(std::exchange(suppressed_, 0)) + " more such events");
    messages_.push_back(std::move(text));
  }
  std::vector<std::string> take() { return std::exchange(messages_, {}); }

 private:
  std::vector<std::string> messages_;
  RateLimit total_;
  uint32_t suppressed_ = 0;
};

}  // namespace fire3dv::app
