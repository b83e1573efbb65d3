#include "protocol/transport/udp_handshake.h"

#include <cstring>

#include "protocol/transport/byte_order.h"

namespace fire3dv::transport::udp {
namespace {

constexpr size_t kModeAt = kHeaderBytes + 8;
constexpr size_t kDatagramBytesAt = kHeaderBytes + 10;
constexpr size_t kRandomAt = kHeaderBytes + 16;
constexpr size_t kHelloProofAt = kHelloBytes - sizeof(Proof);
constexpr size_t kAcceptMoreAt = kHeaderBytes + 8;
constexpr size_t kAcceptDatagramBytes = 8;  // the length and zeros, only when the hello named one
constexpr size_t kAcceptSealBytes = sizeof(Random) + sizeof(Proof);
static_assert(kAcceptMoreAt + kAcceptDatagramBytes + kAcceptSealBytes <= kHelloBytes,
              "an answer must not be longer than the question");

}  // namespace

Hello write_hello(uint64_t nonce, uint64_t cookie, const Random& random, const PreSharedKey* key,
                  uint16_t datagram_bytes) {
  Hello bytes{};
  write_header(bytes.data(), {kTransportVersion, Type::hello, nonce, 0});
  put_le<uint64_t>(&bytes[kHeaderBytes], cookie);
  put_le<uint16_t>(&bytes[kDatagramBytesAt], datagram_bytes);
  if (key == nullptr) return bytes;
  bytes[kModeAt] = std::byte{1};
  std::memcpy(&bytes[kRandomAt], random.data(), random.size());
  const Proof proof = key->prove(std::span(bytes).first<kHelloProofAt>());
  std::memcpy(&bytes[kHelloProofAt], proof.data(), proof.size());
  return bytes;
}

HelloFields read_hello(std::span<const std::byte> datagram) {
  HelloFields fields;
  fields.cookie = get_le<uint64_t>(&datagram[kHeaderBytes]);
  fields.sealed = datagram[kModeAt] != std::byte{0};
  fields.datagram_bytes = get_le<uint16_t>(&datagram[kDatagramBytesAt]);
  std::memcpy(fields.random.data(), &datagram[kRandomAt], fields.random.size());
  std::memcpy(fields.proof.data(), &datagram[kHelloProofAt], fields.proof.size());
  return fields;
}

bool proves_key(std::span<const std::byte> hello, const HelloFields& fields, const PreSharedKey& key) {
  return hello.size() == kHelloBytes && key.check(fields.proof, hello.first(kHelloProofAt));
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

std::vector<std::byte> write_accept(uint64_t nonce, uint64_t session, const Random& publishers,
                                    const Random& listeners, const PreSharedKey* key,
                                    uint16_t datagram_bytes) {
  const Answer answer = write_answer(Type::accept, nonce, session);
  std::vector<std::byte> bytes(answer.begin(), answer.end());
  if (datagram_bytes != 0) {
    bytes.resize(bytes.size() + kAcceptDatagramBytes);
    put_le<uint16_t>(&bytes[kAcceptMoreAt], datagram_bytes);
  }
  if (key == nullptr) return bytes;
  bytes.insert(bytes.end(), listeners.begin(), listeners.end());
  const Proof proof = key->prove(bytes, publishers);
  bytes.insert(bytes.end(), proof.begin(), proof.end());
  return bytes;
}

std::optional<AcceptFields> read_accept(std::span<const std::byte> datagram, const Random& publishers,
                                        const PreSharedKey* key, uint16_t datagram_bytes) {
  const auto session = read_number(datagram.subspan(kHeaderBytes));
  if (!session) return {};
  AcceptFields fields;
  fields.session = *session;
  const size_t seal_bytes = key != nullptr ? kAcceptSealBytes : 0;
  size_t at = kAcceptMoreAt;
  fields.knows_datagram_bytes =
      datagram_bytes == 0 || (datagram.size() == at + kAcceptDatagramBytes + seal_bytes &&
                              get_le<uint16_t>(&datagram[at]) == datagram_bytes);
  if (key == nullptr) return fields;
  if (datagram.size() == at + kAcceptDatagramBytes + seal_bytes) at += kAcceptDatagramBytes;
  if (datagram.size() != at + seal_bytes) return {};
  Proof proof;
  std::memcpy(fields.random.data(), &datagram[at], fields.random.size());
  std::memcpy(proof.data(), &datagram[at + sizeof(Random)], proof.size());
  if (!key->check(proof, datagram.first(at + sizeof(Random)), publishers)) return {};
  return fields;
}

}  // namespace fire3dv::transport::udp
