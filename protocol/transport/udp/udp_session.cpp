#include "protocol/transport/udp/udp_session.h"

#include <cstring>
#include <utility>

#include "protocol/transport/core/byte_order.h"

namespace fire3dv::transport::udp {

bool ReplayWindow::is_new(uint64_t counter) const {
  if (counter == 0) return false;
  if (counter > newest_) return true;
  if (newest_ - counter >= kSpan) return false;
  return (seen_[counter % kSpan / 64] >> (counter % 64) & 1) == 0;
}

void ReplayWindow::mark(uint64_t counter) {
  if (counter > newest_) {
    // Clears the slots that the window moves over.
    const uint64_t steps = std::min(counter - newest_, kSpan);
    for (uint64_t i = 1; i <= steps; ++i) {
      const uint64_t cleared = (counter - steps + i) % kSpan;
      seen_[cleared / 64] &= ~(uint64_t{1} << (cleared % 64));
    }
    newest_ = counter;
  }
  seen_[counter % kSpan / 64] |= uint64_t{1} << (counter % 64);
}

Session::Received Session::receive(const Header& header, std::span<const std::byte> datagram, int64_t now_ns,
                                   std::span<const std::byte>& payload) {
  if (datagram.size() > datagram_bytes_) return Received::too_long;
  if (!window_.is_new(header.counter)) return Received::repeated;
  window_.mark(header.counter);
  payload = datagram.subspan(kHeaderBytes);
  count_received(header.counter, now_ns);
  return Received::payload;
}

Session::Received Session::open(const RecordDatagram& about, std::span<std::byte> datagram, int64_t now_ns,
                                Type& type, std::span<const std::byte>& payload) {
  if (datagram.size() > datagram_bytes_) return Received::too_long;
  std::span<const std::byte> plaintext;
  switch (dtls_->open(datagram, about.record_number, plaintext)) {
    case Dtls::Opened::repeated:
      return Received::repeated;
    case Dtls::Opened::forged:
      return Received::forged;
    case Dtls::Opened::plaintext:
      break;
  }
  count_received(about.record_number & kRecordNumberMask, now_ns);
  type = plaintext.empty() ? Type{} : static_cast<Type>(plaintext[0]);
  payload = plaintext.empty() ? plaintext : plaintext.subspan(1);
  return Received::payload;
}

void Session::repeat_handshake(std::span<const std::byte> datagram, const Emit& emit) {
  dtls_->receive_handshake(datagram);
  for (const auto& answer : dtls_->take_outgoing()) emit(answer);
}

ControlReceiver::Outcome Session::take_piece(Channel& channel, std::span<const std::byte> payload,
                                             size_t budget) {
  using Outcome = ControlReceiver::Outcome;
  FragmentHeader fragment;
  if (!read_fragment_header(payload, fragment)) return Outcome::ignored;
  const Outcome outcome = channel.receiver.fragment(fragment, payload.subspan(kFragmentHeaderBytes), budget);
  channel.owes_ack = channel.owes_ack || outcome == Outcome::accepted || outcome == Outcome::complete;
  return outcome;
}

ControlReceiver::Outcome Session::control(Type type, std::span<const std::byte> payload, size_t budget,
                                          int64_t now_ns) {
  using Outcome = ControlReceiver::Outcome;
  switch (type) {
    case Type::fragment:
      return take_piece(control_, payload, budget);
    case Type::state:
      return take_piece(state_, payload, budget);
    case Type::ack:
    case Type::state_ack: {
      Ack ack;
      if (!read_ack(payload, ack)) return Outcome::ignored;
      (type == Type::ack ? control_ : state_).sender.acknowledge(ack, now_ns);
      return Outcome::accepted;
    }
    case Type::ping:
      owes_pong_ = true;
      return Outcome::accepted;
    case Type::pong:
      return Outcome::accepted;
    default:
      return Outcome::ignored;
  }
}

void Session::emit_finished(Buffer& datagram, size_t bytes, const Emit& emit) {
  const auto whole = finish(datagram, bytes);
  if (!whole.empty()) emit(whole);
}

void Session::emit_due(int64_t now_ns, const Emit& emit) {
  if (std::exchange(owes_pong_, false)) emit_bare(Type::pong, emit);
  emit_due(control_, now_ns, emit);
  emit_due(state_, now_ns, emit);
}

void Session::emit_due(Channel& channel, int64_t now_ns, const Emit& emit) {
  Buffer datagram;
  if (std::exchange(channel.owes_ack, false)) {
    if (const auto ack = channel.receiver.ack()) {
      start(datagram, channel.ack);
      write_ack(datagram.data() + kHeaderBytes, *ack);
      emit_finished(datagram, kHeaderBytes + kAckBytes, emit);
    }
  }
  while (const auto fragment = channel.sender.next(now_ns)) {
    start(datagram, channel.piece);
    write_fragment_header(datagram.data() + kHeaderBytes, fragment->header);
    const size_t data_at = kHeaderBytes + kFragmentHeaderBytes;
    if (!fragment->data.empty())
      std::memcpy(datagram.data() + data_at, fragment->data.data(), fragment->data.size());
    emit_finished(datagram, data_at + fragment->data.size(), emit);
  }
}

void Session::emit_bare(Type type, const Emit& emit) {
  Buffer datagram;
  start(datagram, type);
  emit_finished(datagram, kHeaderBytes, emit);
}

void Session::emit_long_ping(const Emit& emit) {
  Buffer datagram;
  start(datagram, Type::ping);
  const size_t bytes = datagram_bytes_ - kRecordOverheadBytes + kHeaderBytes - 1;
  std::memset(datagram.data() + kHeaderBytes, 0, bytes - kHeaderBytes);
  emit_finished(datagram, bytes, emit);
}

void Session::emit_number(Type type, uint64_t number, const Emit& emit) {
  Buffer datagram;
  start(datagram, type);
  put_le<uint64_t>(datagram.data() + kHeaderBytes, number);
  emit_finished(datagram, kHeaderBytes + 8, emit);
}

void Session::emit_have(uint64_t frame, const Emit& emit) {
  Buffer datagram;
  start(datagram, Type::have);
  put_le<uint64_t>(datagram.data() + kHeaderBytes, frame);
  put_le<uint64_t>(datagram.data() + kHeaderBytes + 8, receipt_.newest);
  put_le<uint64_t>(datagram.data() + kHeaderBytes + 16, receipt_.received);
  emit_finished(datagram, kHeaderBytes + kHaveBytes, emit);
}

std::optional<Receipt> read_receipt(std::span<const std::byte> have) {
  if (have.size() < kHaveBytes) return {};
  return Receipt{get_le<uint64_t>(have.data() + 8), get_le<uint64_t>(have.data() + 16)};
}

}  // namespace fire3dv::transport::udp
