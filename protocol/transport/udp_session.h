// One side of a session between a publisher and a listener: counters, seals, control messages, liveness. No
// I/O of its own: what is to be sent goes to `emit`.
#pragma once

#include <functional>
#include <memory>

#include "protocol/transport/udp_control.h"
#include "protocol/transport/udp_datagram.h"
#include "protocol/transport/udp_seal.h"
#include "protocol/transport/udp_window.h"

namespace fire3dv::transport::udp {

class Session {
 public:
  using Emit = std::function<void(std::span<const std::byte> datagram)>;

  // seal null: datagrams go and come in the open.
  Session(uint64_t id, int64_t now_ns, std::unique_ptr<Seal> seal, size_t datagram_bytes = kDatagramBytes,
          size_t most_received_bytes = kMaxControlBytes)
      : id_(id),
        datagram_bytes_(datagram_bytes),
        heard_at_ns_(now_ns),
        seal_(std::move(seal)),
        control_(Type::fragment, Type::ack, datagram_bytes, most_received_bytes),
        state_(Type::state, Type::state_ack, datagram_bytes, most_received_bytes) {}

  uint64_t id() const { return id_; }
  bool sealed() const { return seal_ != nullptr; }
  int64_t heard_at_ns() const { return heard_at_ns_; }
  ControlSender& sender() { return control_.sender; }
  ControlReceiver& receiver() { return control_.receiver; }
  // Bundles of keyed states go the same way beside them, so that neither waits for the other.
  ControlSender& state_sender() { return state_.sender; }
  ControlReceiver& state_receiver() { return state_.receiver; }

  // This side's next datagram: the header goes to the front of `datagram`, and when the rest has been filled
  // in, to `bytes` in all, finish() gives what is to be sent.
  using Buffer = std::array<std::byte, kMaxDatagramBytes>;
  void start(Buffer& datagram, Type type) {
    write_header(datagram.data(), {kTransportVersion, type, id_, ++sent_});
  }
  std::span<const std::byte> finish(Buffer& datagram, size_t bytes) const {
    return {datagram.data(), seal_ ? seal_->seal(datagram.data(), bytes, sent_) : bytes};
  }

  // A datagram of this session came: its payload, opened in place, or why it is dropped.
  enum class Heard { payload, repeated, forged, too_long };
  Heard hear(const Header& header, std::span<std::byte> datagram, int64_t now_ns,
             std::span<const std::byte>& payload);

  // Takes what is the session's own business (fragment, state, their acks, ping, pong). `complete`:
  // receiver().take(), or of a state state_receiver().take(), has a message.
  ControlReceiver::Outcome control(const Header& header, std::span<const std::byte> payload, size_t budget,
                                   int64_t now_ns);

  // Acknowledgments and fragments that are due.
  void emit_due(int64_t now_ns, const Emit& emit);
  void emit_bare(Type type, const Emit& emit);
  void emit_number(Type type, uint64_t number, const Emit& emit);

 private:
  struct Channel {
    Channel(Type piece_type, Type ack_type, size_t datagram_bytes, size_t most_received_bytes)
        : piece(piece_type),
          ack(ack_type),
          sender(fragment_bytes_of(datagram_bytes)),
          receiver(fragment_bytes_of(datagram_bytes), most_received_bytes) {}
    Type piece, ack;
    ControlSender sender;
    ControlReceiver receiver;
    bool owes_ack = false;
  };
  ControlReceiver::Outcome take_piece(Channel& channel, std::span<const std::byte> payload, size_t budget);
  void emit_due(Channel& channel, int64_t now_ns, const Emit& emit);

  uint64_t id_;
  size_t datagram_bytes_;
  uint64_t sent_ = 0;
  int64_t heard_at_ns_;
  std::unique_ptr<Seal> seal_;
  ReplayWindow window_;
  Channel control_, state_;
  bool owes_pong_ = false;
};

}  // namespace fire3dv::transport::udp
