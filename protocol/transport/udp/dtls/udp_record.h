// Classification of datagrams by their DTLS 1.2 record headers (RFC 6347), which are not encrypted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fire3dv::transport::udp {

constexpr size_t kRecordHeaderBytes = 13;
// Overhead of a sealed record: header and authentication tag.
constexpr size_t kRecordOverheadBytes = kRecordHeaderBytes + 16;
// OpenSSL's replay window: a record that is at least this far behind the newest is dropped as late.
constexpr uint64_t kRecordWindow = 64;

struct RecordDatagram {
  enum class Kind {
    none,          // not sent by any FIRE-3DV peer
    client_hello,  // exactly one unfragmented ClientHello
    handshake,     // other handshake messages; at most one sealed record
    data,          // exactly one sealed record of application data
  };
  Kind kind = Kind::none;
  bool has_sealed = false;
  // Epoch (16 bits) and sequence number (48 bits) of the first record.
  uint64_t record_number = 0;
  // client_hello: the first eight bytes of the client's random, and whether a cookie follows.
  uint64_t nonce = 0;
  bool has_cookie = false;
};

// Alerts are `none`: plaintext alerts can be forged, and messages of our own replace sealed ones.
RecordDatagram inspect_records(std::span<const std::byte> datagram);

}  // namespace fire3dv::transport::udp
