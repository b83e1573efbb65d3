#include "protocol/transport/udp/udp_handshake.h"

#include "protocol/transport/core/byte_order.h"

namespace fire3dv::transport::udp {
namespace {

constexpr size_t kModeAt = kHeaderBytes + 8;
constexpr size_t kDatagramBytesAt = kHeaderBytes + 10;
constexpr size_t kAcceptMoreAt = kHeaderBytes + 8;
constexpr size_t kAcceptDatagramBytes = 8;  // the length and zeros, only when the hello named one
static_assert(kAcceptMoreAt + kAcceptDatagramBytes <= kHelloBytes,
              "an answer must not be longer than the question");

}  // namespace

Hello write_hello(uint64_t nonce, uint64_t cookie, uint16_t datagram_bytes) {
  Hello bytes{};
  write_header(bytes.data(), {kTransportVersion, Type::hello, nonce, 0});
  put_le<uint64_t>(&bytes[kHeaderBytes], cookie);
  put_le<uint16_t>(&bytes[kDatagramBytesAt], datagram_bytes);
  return bytes;
}

HelloFields read_hello(std::span<const std::byte> datagram) {
  HelloFields fields;
  fields.cookie = get_le<uint64_t>(&datagram[kHeaderBytes]);
  fields.mode = std::to_integer<uint8_t>(datagram[kModeAt]);
  fields.datagram_bytes = get_le<uint16_t>(&datagram[kDatagramBytesAt]);
  return fields;
}

Answer write_answer(Type type, uint64_t nonce, uint64_t number) {
  Answer bytes{};
  write_header(bytes.data(), {kTransportVersion, type, nonce, 0});
  put_le<uint64_t>(&bytes[kHeaderBytes], number);
  return bytes;
}

std::optional<uint64_t> read_number(std::span<const std::byte> payload) {
  if (payload.size() < 8) return {};
  return get_le<uint64_t>(payload.data());
}

std::vector<std::byte> write_accept(uint64_t nonce, uint64_t session, uint16_t datagram_bytes) {
  const Answer answer = write_answer(Type::accept, nonce, session);
  std::vector<std::byte> bytes(answer.begin(), answer.end());
  if (datagram_bytes == 0) return bytes;
  bytes.resize(bytes.size() + kAcceptDatagramBytes);
  put_le<uint16_t>(&bytes[kAcceptMoreAt], datagram_bytes);
  return bytes;
}

std::optional<AcceptFields> read_accept(std::span<const std::byte> datagram, uint16_t datagram_bytes) {
  const auto session = read_number(datagram.subspan(kHeaderBytes));
  if (!session) return {};
  AcceptFields fields;
  fields.session = *session;
  fields.knows_datagram_bytes =
      datagram_bytes == 0 || (datagram.size() == kAcceptMoreAt + kAcceptDatagramBytes &&
                              get_le<uint16_t>(&datagram[kAcceptMoreAt]) == datagram_bytes);
  return fields;
}

Parameters read_parameters(uint64_t number) {
  return {static_cast<uint8_t>(number), static_cast<uint8_t>(number >> 8),
          static_cast<uint16_t>(number >> 16)};
}

std::vector<std::byte> seal_number(Dtls& dtls, Type type, uint64_t number) {
  constexpr size_t kPlaintextBytes = 9;
  std::vector<std::byte> datagram(kPlaintextBytes + kRecordOverheadBytes);
  datagram[0] = static_cast<std::byte>(type);
  put_le<uint64_t>(&datagram[1], number);
  datagram.resize(dtls.seal(datagram, 0, kPlaintextBytes));
  return datagram;
}

std::optional<SealedNumber> open_number(Dtls& dtls, const RecordDatagram& about,
                                        std::span<std::byte> datagram) {
  std::span<const std::byte> plaintext;
  if (dtls.open(datagram, about.record_number, plaintext) != Dtls::Opened::plaintext || plaintext.empty())
    return {};
  const auto number = read_number(plaintext.subspan(1));
  if (!number) return {};
  return SealedNumber{static_cast<Type>(plaintext[0]), *number};
}

}  // namespace fire3dv::transport::udp
