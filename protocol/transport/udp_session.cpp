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

ControlReceiver::Outcome Session::control(const Header& header, std::span<const std::byte> payload,
                                          size_t budget, int64_t now_ns) {
  using Outcome = ControlReceiver::Outcome;
  switch (header.type) {
    case Type::fragment: {
      FragmentHeader fragment;
      if (!read_fragment_header(payload, fragment)) return Outcome::ignored;
      const Outcome outcome = receiver_.fragment(fragment, payload.subspan(kFragmentHeaderBytes), budget);
      owes_ack_ = owes_ack_ || outcome == Outcome::kept || outcome == Outcome::complete;
      return outcome;
    }
    case Type::ack: {
      Ack ack;
      if (!read_ack(payload, ack)) return Outcome::ignored;
      sender_.acknowledge(ack, now_ns);
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
  Buffer datagram;
  if (std::exchange(owes_pong_, false)) emit_bare(Type::pong, emit);
  if (std::exchange(owes_ack_, false)) {
    if (const auto ack = receiver_.ack()) {
      start(datagram, Type::ack);
      write_ack(datagram.data() + kHeaderBytes, *ack);
      emit(finish(datagram, kHeaderBytes + kAckBytes));
    }
  }
  while (const auto fragment = sender_.next(now_ns)) {
    start(datagram, Type::fragment);
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
