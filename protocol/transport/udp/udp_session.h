// One side of a session between a publisher and a listener: counters, sealing, control messages, liveness. No
// I/O of its own: what is to be sent goes to `emit`.
#pragma once

#include <functional>
#include <memory>

#include "protocol/transport/udp/dtls/udp_dtls.h"
#include "protocol/transport/udp/udp_control.h"
#include "protocol/transport/udp/udp_datagram.h"
#include "protocol/transport/udp/udp_window.h"

namespace fire3dv::transport::udp {

class Session {
 public:
  using Emit = std::function<void(std::span<const std::byte> datagram)>;

  // dtls null: datagrams go and come in the open, under this id. Else its handshake is done, and nothing sees
  // the id.
  Session(uint64_t id, int64_t now_ns, std::unique_ptr<Dtls> dtls, size_t datagram_bytes = kDatagramBytes,
          size_t most_received_bytes = kMaxControlBytes)
      : id_(id),
        datagram_bytes_(datagram_bytes),
        heard_at_ns_(now_ns),
        dtls_(std::move(dtls)),
        control_(Type::fragment, Type::ack, datagram_bytes, most_received_bytes),
        state_(Type::state, Type::state_ack, datagram_bytes, most_received_bytes) {}

  uint64_t id() const { return id_; }
  bool sealed() const { return dtls_ != nullptr; }
  size_t datagram_bytes() const { return datagram_bytes_; }
  // Nothing can be sealed any more.
  bool broken() const { return dtls_ && dtls_->broken(); }
  int64_t heard_at_ns() const { return heard_at_ns_; }
  ControlSender& sender() { return control_.sender; }
  ControlReceiver& receiver() { return control_.receiver; }
  // Bundles of keyed states go the same way beside them, so that neither waits for the other.
  ControlSender& state_sender() { return state_.sender; }
  ControlReceiver& state_receiver() { return state_.receiver; }

  // This side's next datagram: the header goes to the front of `datagram`, and when the rest has been filled
  // in, to `bytes` in all, finish() gives what is to be sent; nothing when the session is broken.
  using Buffer = std::array<std::byte, kMaxDatagramBytes>;
  void start(Buffer& datagram, Type type) {
    if (dtls_)
      datagram[kHeaderBytes - 1] = static_cast<std::byte>(type);  // all that is left of the header
    else
      write_header(datagram.data(), {kTransportVersion, type, id_, ++sent_});
  }
  std::span<const std::byte> finish(Buffer& datagram, size_t bytes) {
    return {datagram.data(),
            dtls_ ? dtls_->seal(datagram, kHeaderBytes - 1, bytes - (kHeaderBytes - 1)) : bytes};
  }

  // A datagram of this session came: its payload, or why it is dropped.
  enum class Heard { payload, repeated, forged, too_long };
  Heard hear(const Header& header, std::span<const std::byte> datagram, int64_t now_ns,
             std::span<const std::byte>& payload);
  // A sealed one, opened in place.
  Heard open(const RecordDatagram& about, std::span<std::byte> datagram, int64_t now_ns, Type& type,
             std::span<const std::byte>& payload);
  // What the other side sends when it has missed the end of the handshake.
  void repeat_handshake(std::span<const std::byte> datagram, const Emit& emit);

  // Takes what is the session's own business (fragment, state, their acks, ping, pong). `complete`:
  // receiver().take(), or of a state state_receiver().take(), has a message.
  ControlReceiver::Outcome control(Type type, std::span<const std::byte> payload, size_t budget,
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
  void emit_finished(Buffer& datagram, size_t bytes, const Emit& emit);

  uint64_t id_;
  size_t datagram_bytes_;
  uint64_t sent_ = 0;
  int64_t heard_at_ns_;
  std::unique_ptr<Dtls> dtls_;
  ReplayWindow window_;  // of a session that is not sealed
  Channel control_, state_;
  bool owes_pong_ = false;
};

}  // namespace fire3dv::transport::udp
