// Datagrams of DTLS 1.2: their classification, and the BIO through which OpenSSL reads and writes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

struct bio_st;

namespace fire3dv::transport::udp {

constexpr size_t kRecordHeaderBytes = 13;
// Overhead of a sealed record: header and authentication tag.
constexpr size_t kRecordOverheadBytes = kRecordHeaderBytes + 16;
// OpenSSL's replay window: a record that is at least this far behind the newest is dropped as late.
constexpr uint64_t kRecordWindow = 64;

// Classification of a datagram by its record headers (RFC 6347), which are not encrypted.
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

struct DatagramEnds {
  // Datagram of the next read; later reads return "retry".
  std::span<const std::byte> incoming;
  // Destination of the next application data record, so that sealing does not allocate.
  std::span<std::byte> sealed;
  size_t sealed_bytes = 0;
  // All other written datagrams except alerts, which both sides ignore.
  std::vector<std::vector<std::byte>> outgoing;
};

// In-memory datagram BIO: each read consumes one datagram and each write produces one. BIO_s_mem does not
// preserve datagram boundaries; BIO_s_dgram_mem does, but needs OpenSSL 3.2. Returns null if out of memory.
// `ends` must outlive the BIO.
bio_st* make_datagram_bio(DatagramEnds& ends);

}  // namespace fire3dv::transport::udp
