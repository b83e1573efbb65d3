// Headers of DTLS 1.2 records (RFC 6347), which are readable without keys: they tell where a datagram
// belongs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fire3dv::transport::udp {

constexpr size_t kRecordHeaderBytes = 13;
// What a sealed record has more than its plaintext: the header and the tag.
constexpr size_t kRecordOverheadBytes = kRecordHeaderBytes + 16;
// OpenSSL's replay window: a record that is so many behind the newest is dropped as late.
constexpr uint64_t kRecordWindow = 64;

struct RecordDatagram {
  enum class Kind {
    none,          // nothing that a peer of ours sends
    client_hello,  // the first message of a handshake, whole and alone
    handshake,     // any other messages of one; at most one record of them is sealed
    data,          // one sealed record of application data, and nothing else
  };
  Kind kind = Kind::none;
  bool has_sealed = false;
  // Epoch (16 bits) and sequence number (48 bits) of the first record.
  uint64_t record_number = 0;
  // client_hello: the first eight bytes of the client's random, and whether a cookie follows.
  uint64_t nonce = 0;
  bool has_cookie = false;
};

// Alerts are `none`: those in the open can be forged, and our own messages stand for the others.
RecordDatagram inspect_records(std::span<const std::byte> datagram);

}  // namespace fire3dv::transport::udp
