// One side of a session between a publisher and a listener: counters, control messages, liveness. No I/O of
// its own: what is to be sent goes to `emit`.
#pragma once

#include <cstring>
#include <functional>
#include <utility>

#include "protocol/transport/udp_control.h"
#include "protocol/transport/udp_datagram.h"
#include "protocol/transport/udp_window.h"

namespace fire3dv::transport::udp {

class Session {
 public:
  using Emit = std::function<void(std::span<const std::byte> datagram)>;

  Session(uint64_t id, int64_t now_ns) : id_(id), heard_at_ns_(now_ns) {}

  uint64_t id() const { return id_; }
  int64_t heard_at_ns() const { return heard_at_ns_; }
  ControlSender& sender() { return sender_; }
  ControlReceiver& receiver() { return receiver_; }

  // The header of this side's next datagram, and room behind it.
  using Buffer = std::array<std::byte, kMaxDatagramBytes>;
  void start(Buffer& datagram, Type type) {
    write_header(datagram.data(), {kTransportVersion, type, id_, ++sent_});
  }

  // A datagram of this session came. False when it is a repetition.
  bool heard(const Header& header, int64_t now_ns);

  // Takes what is the session's own business (fragment, ack, ping, pong). `complete`: receiver().take() has a
  // message.
  ControlReceiver::Outcome control(const Header& header, std::span<const std::byte> payload, size_t budget,
                                   int64_t now_ns);

  // Acknowledgments and fragments that are due.
  void emit_due(int64_t now_ns, const Emit& emit);
  void emit_bare(Type type, const Emit& emit);

 private:
  uint64_t id_;
  uint64_t sent_ = 0;
  int64_t heard_at_ns_;
  ReplayWindow window_;
  ControlSender sender_;
  ControlReceiver receiver_;
  bool owes_ack_ = false;
  bool owes_pong_ = false;
};

}  // namespace fire3dv::transport::udp
