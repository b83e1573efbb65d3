// What the listeners of TCP and UDP have in common: a thread that receives, and an inbox that the caller
// polls.
#pragma once

#include <algorithm>
#include <string>
#include <utility>

#include "protocol/transport/clock.h"
#include "protocol/transport/inbox.h"
#include "protocol/transport/link_counters.h"
#include "protocol/transport/link_thread.h"
#include "protocol/transport/open.h"

namespace fire3dv::transport {

class NetworkListener : public ListenerLink {
 public:
  void poll(const std::function<void(const LinkEvent&)>& on_event) override { inbox_.poll(on_event); }
  void wait(std::chrono::nanoseconds timeout) final { inbox_.wait(timeout); }
  LinkStats stats() const final { return counters_.snapshot(); }
  std::string uri() const final { return uri_; }

 protected:
  NetworkListener(std::string uri, ListenerOptions options)
      : uri_(std::move(uri)), options_(std::move(options)), inbox_(counters_, options_.max_memory_bytes) {}

  // Peers that left count until their end was polled, or a caller that does not poll would be filled with
  // them.
  bool is_full(size_t peers) const {
    return peers >= options_.max_peers || inbox_.entries() >= size_t{2} * options_.max_peers;
  }
  // Who came and has said nothing for this long gives its place to another when all are taken: places cost an
  // attacker nothing else.
  static constexpr int64_t kSilentGuestNs = 5 * kSecondNs;
  static constexpr const char* kSilentGuest = "it has said nothing yet, and its place was needed";

  void reject(Cause cause, const std::string& what) {
    counters_.reject(cause);
    inbox_.note_once(uri_ + ": " + what);
  }

  const std::string uri_;
  const ListenerOptions options_;
  LinkCounters counters_;
  Inbox inbox_;
  LinkThread thread_;
  PeerId last_id_ = 0;  // on the listener's thread alone
};

}  // namespace fire3dv::transport
