// Publisher of a sealed udp:// link whose listener has no thread: the caller serves it between two
// measurements.
#pragma once

#include <netinet/in.h>

#include <memory>
#include <vector>

#include "protocol/transport/udp_session.h"
#include "tools/bench/dtls_loopback.h"
#include "tools/bench/simulator.h"

namespace fire3dv::bench {

constexpr uint64_t kBenchSession = 17;

std::unique_ptr<transport::udp::Session> make_sealed_session(transport::udp::PreSharedKey::Side side,
                                                             const transport::udp::Random& publishers,
                                                             const transport::udp::Random& listeners,
                                                             size_t datagram_bytes);

class SealedLink {
 public:
  // Returns when the first pose has come.
  Result<void> open(size_t poses, size_t datagram_bytes);
  void publish() { simulator_->publish(); }
  // Takes and answers all datagrams that have come.
  void serve();

  const HandshakeCount& handshake() const { return count_; }
  size_t added_bytes() const { return added_bytes_; }  // to a pose datagram's plaintext

 private:
  void handle(std::span<std::byte> datagram);
  void answer_hello(uint64_t nonce, std::span<const std::byte> hello);
  void reply(std::span<const std::byte> bytes) const;

  transport::UniqueFd listener_;
  sockaddr_in publisher_{};
  std::unique_ptr<transport::udp::Session> session_;
  std::unique_ptr<Simulator> simulator_;
  HandshakeCount count_;
  size_t added_bytes_ = 0;
  uint64_t nonce_ = 0;
  std::vector<std::byte> cookie_, accept_;  // the answers to hellos with this nonce
  bool pose_came_ = false;
};

}  // namespace fire3dv::bench
