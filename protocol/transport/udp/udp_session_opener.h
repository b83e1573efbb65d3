// Handshake of a UDP publisher: cookie exchange, or DTLS handshake and sealed hello.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "protocol/transport/core/address.h"
#include "protocol/transport/core/link_counters.h"
#include "protocol/transport/core/link_thread.h"
#include "protocol/transport/udp/udp_datagram.h"
#include "protocol/transport/udp/udp_dtls.h"
#include "protocol/transport/udp/udp_session.h"

namespace fire3dv::transport::udp {

constexpr size_t kMaxReplyBytes = 4 << 20;

// One attempt with one address, on the link's thread.
class SessionOpener {
 public:
  // Borrows all. fd: a connected socket that does not block. key: null for a plaintext session.
  SessionOpener(int fd, const Uri& uri, const PreSharedKey* key, size_t datagram_bytes, LinkThread& thread,
                LinkCounters& counters);

  // Null if the listener refuses, or if none answers for three seconds.
  std::unique_ptr<Session> open();
  // Problem of the link if the listener has given a reason; else empty.
  const std::string& refusal() const { return refusal_; }

 private:
  std::unique_ptr<Session> open_plain();
  std::unique_ptr<Session> open_sealed();
  std::unique_ptr<Session> receive_answer(std::unique_ptr<Dtls>& dtls, std::span<std::byte> datagram);
  bool wait_for_answer(int64_t until_ns, std::span<std::byte>& datagram);
  void refuse(uint64_t answer, uint8_t version);

  const int fd_;
  const Uri& uri_;
  const PreSharedKey* const key_;
  const size_t datagram_bytes_;
  LinkThread& thread_;
  LinkCounters& counters_;
  bool is_refused_ = false;
  std::string refusal_;
  std::array<std::byte, kMaxDatagramBytes + 1> buffer_;
};

}  // namespace fire3dv::transport::udp
