// Publisher of a udp:// link, with a key or without, whose listener has no thread: the caller serves it
// between two measurements.
#pragma once

#include <netinet/in.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "protocol/transport/udp/udp_session.h"
#include "tools/lab/bench/links/simulator.h"

namespace fire3dv::bench {

// Two UDP sockets on 127.0.0.1 that are connected with each other.
struct SocketPair {
  UniqueFd from, to;
};
Result<SocketPair> make_socket_pair();

// Both ends of a session: a publisher's and a listener's.
struct SessionPair {
  std::unique_ptr<transport::udp::Session> from, to;
};
Result<SessionPair> make_session_pair(bool sealed, size_t datagram_bytes);
// A listener's end that has answered a ClientHello with its cookie.
Result<std::unique_ptr<transport::udp::Dtls>> make_pending_handshake();

// Datagrams before the first description or pose, in both directions; UDP payload alone.
struct HandshakeCount {
  size_t datagrams = 0, bytes = 0, round_trips = 0;
  bool last_was_publisher = false;
  void add(bool is_publisher, size_t datagram_bytes);
};

class ServedLink {
 public:
  // Returns when the first pose has come.
  Result<void> open(size_t poses, size_t datagram_bytes, bool sealed);
  void publish() { simulator_->publish(); }
  // Takes and answers all datagrams that have come.
  void serve();

  const HandshakeCount& handshake() const { return count_; }
  size_t added_bytes() const { return added_bytes_; }  // to a pose datagram's plaintext

 private:
  void handle(std::span<std::byte> datagram);
  void handle_sealed(std::span<std::byte> datagram);
  void shake_hands(const transport::udp::RecordDatagram& about, std::span<const std::byte> datagram);
  void take(transport::udp::Type type, std::span<const std::byte> payload, size_t datagram_bytes);
  void reply(std::span<const std::byte> bytes) const;
  // A greeting and its answers, counted once however often the publisher repeats it.
  void count(size_t question_bytes, const std::vector<std::vector<std::byte>>& answers);

  UniqueFd listener_;
  sockaddr_in publisher_{};
  std::shared_ptr<const transport::udp::PreSharedKey> key_;  // null: not sealed
  std::unique_ptr<transport::udp::Dtls> dtls_;               // until its handshake is over
  bool greeted_ = false;
  std::unique_ptr<transport::udp::Session> session_;
  std::unique_ptr<Simulator> simulator_;
  HandshakeCount count_;
  std::vector<std::pair<size_t, uint64_t>> counted_;  // lengths and first numbers of greetings
  size_t datagram_bytes_ = 0;
  size_t added_bytes_ = 0;
  bool pose_came_ = false;
};

}  // namespace fire3dv::bench
