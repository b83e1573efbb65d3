// One side of a session between a publisher and a listener: counters, sealing, control messages, liveness. No
// I/O: `emit` receives the datagrams to send.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "protocol/transport/udp/udp_control.h"
#include "protocol/transport/udp/udp_datagram.h"
#include "protocol/transport/udp/udp_dtls.h"

namespace fire3dv::transport::udp {

// Anti-replay window: accepts each datagram counter once. A counter older than the window counts as replayed.
class ReplayWindow {
 public:
  bool is_new(uint64_t counter) const;
  // Call only for authenticated datagrams: a forged counter would otherwise lock the peer out.
  void mark(uint64_t counter);

 private:
  static constexpr uint64_t kSpan = 4096;
  std::array<uint64_t, kSpan / 64> seen_{};
  uint64_t newest_ = 0;
};

// Receipt of a session's datagrams, as its listener reports it: cumulative, so that lost reports cost
// nothing.
struct Receipt {
  uint64_t newest = 0;    // highest counter, or record number of a sealed session
  uint64_t received = 0;  // number of datagrams
  bool operator==(const Receipt&) const = default;
};

constexpr size_t kHaveBytes = 24;
constexpr uint64_t kRecordNumberMask = (uint64_t{1} << 48) - 1;  // above it the epoch
// Nothing from listeners that do not count.
std::optional<Receipt> read_receipt(std::span<const std::byte> have);

class Session {
 public:
  using Emit = std::function<void(std::span<const std::byte> datagram)>;

  // dtls null: plaintext datagrams that carry `id`. Otherwise its handshake is complete, and `id` is local.
  Session(uint64_t id, int64_t now_ns, std::unique_ptr<Dtls> dtls, size_t datagram_bytes = kDatagramBytes,
          size_t max_received_bytes = kMaxControlBytes)
      : id_(id),
        datagram_bytes_(datagram_bytes),
        last_received_ns_(now_ns),
        dtls_(std::move(dtls)),
        control_(Type::fragment, Type::ack, datagram_bytes, max_received_bytes),
        state_(Type::state, Type::state_ack, datagram_bytes, max_received_bytes) {}

  uint64_t id() const { return id_; }
  bool sealed() const { return dtls_ != nullptr; }
  size_t datagram_bytes() const { return datagram_bytes_; }
  // The DTLS session has failed; nothing can be sealed any more.
  bool broken() const { return dtls_ && dtls_->broken(); }
  int64_t last_received_ns() const { return last_received_ns_; }
  const Receipt& receipt() const { return receipt_; }
  // True if a sealed datagram is too old for the replay window.
  bool is_late(const RecordDatagram& about) const {
    return (about.record_number & kRecordNumberMask) + kRecordWindow <= receipt_.newest;
  }
  ControlSender& sender() { return control_.sender; }
  ControlReceiver& receiver() { return control_.receiver; }
  // Bundles of keyed states have their own channel, so that neither delays the other.
  ControlSender& state_sender() { return state_.sender; }
  ControlReceiver& state_receiver() { return state_.receiver; }

  // Writes the header of the next datagram. The caller appends the payload and passes the total length to
  // finish(), which returns the bytes to send; empty if the session is broken.
  using Buffer = std::array<std::byte, kMaxDatagramBytes>;
  void start(Buffer& datagram, Type type) {
    if (dtls_)
      datagram[kHeaderBytes - 1] =
          static_cast<std::byte>(type);  // a sealed datagram has no other header field
    else
      write_header(datagram.data(), {kTransportVersion, type, id_, ++sent_});
  }
  std::span<const std::byte> finish(Buffer& datagram, size_t bytes) {
    return {datagram.data(),
            dtls_ ? dtls_->seal(datagram, kHeaderBytes - 1, bytes - (kHeaderBytes - 1)) : bytes};
  }

  // Validates a received plaintext datagram: payload, or the reason why it is dropped.
  enum class Received { payload, repeated, forged, too_long };
  Received receive(const Header& header, std::span<const std::byte> datagram, int64_t now_ns,
                   std::span<const std::byte>& payload);
  // Same for a sealed datagram, decrypted in place.
  Received open(const RecordDatagram& about, std::span<std::byte> datagram, int64_t now_ns, Type& type,
                std::span<const std::byte>& payload);
  // Answers a repeated handshake message: the other side has missed our last flight.
  void repeat_handshake(std::span<const std::byte> datagram, const Emit& emit);

  // Processes fragment, state, ack, state_ack, ping and pong. complete: receiver().take(), or
  // state_receiver().take() for a state, returns a message.
  ControlReceiver::Outcome control(Type type, std::span<const std::byte> payload, size_t budget,
                                   int64_t now_ns);

  // Emits acknowledgments and fragments that are due.
  void emit_due(int64_t now_ns, const Emit& emit);
  void emit_bare(Type type, const Emit& emit);
  // A ping as long as the longest datagrams of this session.
  void emit_long_ping(const Emit& emit);
  void emit_number(Type type, uint64_t number, const Emit& emit);
  // The newest complete frame, and the receipt of this session's datagrams.
  void emit_have(uint64_t frame, const Emit& emit);

 private:
  struct Channel {
    Channel(Type piece_type, Type ack_type, size_t datagram_bytes, size_t max_received_bytes)
        : piece(piece_type),
          ack(ack_type),
          sender(fragment_bytes_of(datagram_bytes)),
          receiver(fragment_bytes_of(datagram_bytes), max_received_bytes) {}
    Type piece, ack;
    ControlSender sender;
    ControlReceiver receiver;
    bool owes_ack = false;
  };
  ControlReceiver::Outcome take_piece(Channel& channel, std::span<const std::byte> payload, size_t budget);
  void emit_due(Channel& channel, int64_t now_ns, const Emit& emit);
  void emit_finished(Buffer& datagram, size_t bytes, const Emit& emit);
  void count_received(uint64_t number, int64_t now_ns) {
    receipt_.newest = std::max(receipt_.newest, number);
    ++receipt_.received;
    last_received_ns_ = now_ns;
  }

  uint64_t id_;
  size_t datagram_bytes_;
  uint64_t sent_ = 0;
  int64_t last_received_ns_;
  Receipt receipt_;
  std::unique_ptr<Dtls> dtls_;
  ReplayWindow window_;  // of a plaintext session
  Channel control_, state_;
  bool owes_pong_ = false;
};

}  // namespace fire3dv::transport::udp
