#include "protocol/transport/udp_session.h"

#include <cstring>
#include <utility>

#include "protocol/transport/byte_order.h"

namespace fire3dv::transport::udp {

Session::Heard Session::hear(const Header& header, std::span<std::byte> datagram, int64_t now_ns,
                             std::span<const std::byte>& payload) {
  if (datagram.size() > datagram_bytes_) return Heard::too_long;
  if (!window_.is_new(header.counter)) return Heard::repeated;
  if (seal_) {
    const auto opened = seal_->open(datagram, header.counter);
    if (!opened) return Heard::forged;
    payload = *opened;
  } else {
    payload = datagram.subspan(kHeaderBytes);
  }
  window_.mark(header.counter);
  heard_at_ns_ = now_ns;
  return Heard::payload;
}

ControlReceiver::Outcome Session::take_piece(Channel& channel, std::span<const std::byte> payload,
                                             size_t budget) {
  using Outcome = ControlReceiver::Outcome;
  FragmentHeader fragment;
  if (!read_fragment_header(payload, fragment)) return Outcome::ignored;
  const Outcome outcome = channel.receiver.fragment(fragment, payload.subspan(kFragmentHeaderBytes), budget);
  channel.owes_ack = channel.owes_ack || outcome == Outcome::kept || outcome == Outcome::complete;
  return outcome;
}

ControlReceiver::Outcome Session::control(const Header& header, std::span<const std::byte> payload,
                                          size_t budget, int64_t now_ns) {
  using Outcome = ControlReceiver::Outcome;
  switch (header.type) {
    case Type::fragment:
      return take_piece(control_, payload, budget);
    case Type::state:
      return take_piece(state_, payload, budget);
    case Type::ack:
    case Type::state_ack: {
      Ack ack;
      if (!read_ack(payload, ack)) return Outcome::ignored;
      (header.type == Type::ack ? control_ : state_).sender.acknowledge(ack, now_ns);
      return Outcome::kept;
    }
    case Type::ping:
      owes_pong_ = true;
      return Outcome::kept;
    case Type::pong:
      return Outcome::kept;
    default:
      return Outcome::ignored;
  }
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
      emit(finish(datagram, kHeaderBytes + kAckBytes));
    }
  }
  while (const auto fragment = channel.sender.next(now_ns)) {
    start(datagram, channel.piece);
    write_fragment_header(datagram.data() + kHeaderBytes, fragment->header);
    const size_t data_at = kHeaderBytes + kFragmentHeaderBytes;
    if (!fragment->data.empty())
      std::memcpy(datagram.data() + data_at, fragment->data.data(), fragment->data.size());
    emit(finish(datagram, data_at + fragment->data.size()));
  }
}

void Session::emit_bare(Type type, const Emit& emit) {
  Buffer datagram;
  start(datagram, type);
  emit(finish(datagram, kHeaderBytes));
}

void Session::emit_number(Type type, uint64_t number, const Emit& emit) {
  Buffer datagram;
  start(datagram, type);
  put_le<uint64_t>(datagram.data() + kHeaderBytes, number);
  emit(finish(datagram, kHeaderBytes + 8));
}

}  // namespace fire3dv::transport::udp
