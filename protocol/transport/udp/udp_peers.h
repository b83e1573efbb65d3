// Peers of a UDP listener, by session and by address.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "base/clock.h"
#include "base/peer_budget.h"
#include "protocol/transport/core/address.h"
#include "protocol/transport/link.h"
#include "protocol/transport/udp/udp_poses.h"
#include "protocol/transport/udp/udp_session.h"

namespace fire3dv::transport::udp {

constexpr int64_t kReceiptEveryNs = 100 * kMillisecondNs;

struct Peer {
  PeerId id = 0;
  uint64_t nonce = 0;
  Address address;
  Session session;
  std::vector<std::byte> accept;  // plaintext answer, repeated if it was lost
  ReceivedPoses poses;
  uint64_t acknowledged_frame = 0;  // newest whole frame sent in a `have` message
  Receipt reported;                 // receipt of the last `have` message
  int64_t reported_at_ns = 0;
  bool has_poses = false;  // pose datagrams were received
  bool is_mute_noted = false;
  uint64_t late_records = 0;  // outside the replay window of DTLS
  int64_t connected_at_ns = 0;
  int64_t last_message_ns = 0;  // arrival of the last pose or fragment of a control message
  std::shared_ptr<PeerBudget> budget;
  BudgetCharge pieces, parity;  // fragments of incomplete control messages; parts and parity of frames

  // A pose, or a fragment of a control message.
  bool has_any_message() const { return last_message_ns != connected_at_ns; }
  // A report of received datagrams is due: soon after a loss, else in intervals, while datagrams come.
  bool owes_receipt(int64_t now_ns) const {
    const Receipt& now = session.receipt();
    const bool has_lost = now.newest - now.received != reported.newest - reported.received;
    return has_poses && now.received != reported.received &&
           (has_lost || now_ns - reported_at_ns >= kReceiptEveryNs);
  }
};

// Used on the listener's thread only.
class PeerTable {
 public:
  // An address has one session: the earlier one must be removed before. Valid until the peer is removed.
  Peer& add(uint64_t session, Peer&& newcomer);
  void remove(uint64_t session);

  Peer* find(uint64_t session);
  uint64_t session_at(const Address& address) const;  // 0: none
  uint64_t session_of(PeerId peer) const;             // 0: none
  Peer* find_at(const Address& address) { return find(session_at(address)); }

  size_t size() const { return peers_.size(); }
  // Pairs of session and peer.
  auto begin() { return peers_.begin(); }
  auto end() { return peers_.end(); }

 private:
  std::unordered_map<uint64_t, Peer> peers_;
  std::unordered_map<Address, uint64_t, AddressHash> session_at_;
};

}  // namespace fire3dv::transport::udp
