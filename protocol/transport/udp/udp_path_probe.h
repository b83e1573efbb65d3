// Detection of paths that drop long datagrams without a word (black holes of path MTU discovery), after RFC
// 8899: in rounds, a publisher sends a ping as long as its datagrams may be, then a short one. Listeners of
// every version answer both. A path that answers short ones only, in several rounds in a row, does not carry
// the long ones. No I/O; the caller passes the time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/clock.h"
#include "protocol/transport/udp/udp_datagram.h"

namespace fire3dv::transport::udp {

class PathProbe {
 public:
  enum class Ping { none, whole_length, bare };

  void start_session(int64_t now_ns) {
    *this = {};
    round_at_ns_ = now_ns;
  }

  // Called regularly. Returns the ping that is due.
  Ping due(int64_t now_ns) {
    if (now_ns >= round_at_ns_) {
      end_round();
      round_at_ns_ = now_ns + (is_confirmed_ ? kLaterRoundNs : kFirstRoundNs);
      bare_at_ns_ = now_ns + kBareAfterNs;
      return Ping::whole_length;
    }
    if (bare_at_ns_ == 0 || now_ns < bare_at_ns_) return Ping::none;
    bare_at_ns_ = 0;
    if (pongs_ != 0) return Ping::none;
    sent_bare_ = true;
    return Ping::bare;
  }

  void on_pong() { ++pongs_; }
  // A datagram longer than the next shorter length has arrived.
  void on_long_datagram() {
    failed_rounds_ = 0;
    is_confirmed_ = true;
  }
  // True if the path answers, and drops long datagrams.
  bool has_black_hole() const { return failed_rounds_ >= kMaxFailedRounds; }

 private:
  // Two pings and two pongs: both arrived. Two pings and one pong: the short one did.
  void end_round() {
    if (sent_bare_ ? pongs_ >= 2 : pongs_ != 0) on_long_datagram();
    if (sent_bare_ && pongs_ == 1) ++failed_rounds_;
    sent_bare_ = false;
    pongs_ = 0;
  }

  static constexpr int64_t kFirstRoundNs = kSecondNs / 2, kLaterRoundNs = kSecondNs;
  static constexpr int64_t kBareAfterNs = kSecondNs / 4;
  static constexpr int kMaxFailedRounds = 4;

  int64_t round_at_ns_ = 0, bare_at_ns_ = 0;
  int pongs_ = 0, failed_rounds_ = 0;
  bool sent_bare_ = false, is_confirmed_ = false;
};

// The datagram length to try on a path that does not carry this one, if any.
constexpr std::optional<size_t> shorter_datagram_bytes(size_t bytes) {
  if (bytes > kDatagramBytes) return kDatagramBytes;
  if (bytes > kLeastDatagramBytes) return kLeastDatagramBytes;
  return {};
}

}  // namespace fire3dv::transport::udp
