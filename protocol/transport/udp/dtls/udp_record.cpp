#include "protocol/transport/udp/dtls/udp_record.h"

namespace fire3dv::transport::udp {
namespace {

constexpr unsigned kChangeCipherSpec = 20, kHandshake = 22, kApplicationData = 23;
constexpr unsigned kVersionMajor = 0xfe;  // of all versions of DTLS
constexpr unsigned kClientHello = 1;
constexpr size_t kHandshakeHeaderBytes = 12;
constexpr size_t kRandomAt = kRecordHeaderBytes + kHandshakeHeaderBytes + 2;  // after the client's version
constexpr size_t kSessionAt = kRandomAt + 32;

unsigned byte_at(std::span<const std::byte> bytes, size_t at) {
  return std::to_integer<unsigned>(bytes[at]);
}

uint64_t big_endian(std::span<const std::byte> bytes, size_t at, size_t count) {
  uint64_t value = 0;
  for (size_t i = 0; i < count; ++i) value = value << 8 | byte_at(bytes, at + i);
  return value;
}

// Reads the fields up to the cookie of a ClientHello. Returns false if it is truncated or fragmented.
bool read_client_hello(std::span<const std::byte> record, RecordDatagram& datagram) {
  if (record.size() < kSessionAt + 2) return false;
  const uint64_t length = big_endian(record, kRecordHeaderBytes + 1, 3);
  const uint64_t piece_at = big_endian(record, kRecordHeaderBytes + 6, 3);
  const uint64_t piece_length = big_endian(record, kRecordHeaderBytes + 9, 3);
  if (piece_at != 0 || piece_length != length ||
      length + kRecordHeaderBytes + kHandshakeHeaderBytes != record.size())
    return false;
  const size_t cookie_at = kSessionAt + 1 + byte_at(record, kSessionAt);
  if (cookie_at >= record.size()) return false;
  datagram.nonce = big_endian(record, kRandomAt, 8);
  datagram.has_cookie = byte_at(record, cookie_at) != 0;
  return true;
}

}  // namespace

RecordDatagram inspect_records(std::span<const std::byte> datagram) {
  using Kind = RecordDatagram::Kind;
  RecordDatagram result;
  size_t records = 0, sealed = 0;
  bool has_data = false, has_hello = false;
  for (size_t at = 0; at < datagram.size(); ++records) {
    const std::span<const std::byte> rest = datagram.subspan(at);
    if (rest.size() < kRecordHeaderBytes || byte_at(rest, 1) != kVersionMajor) return {};
    const unsigned type = byte_at(rest, 0);
    const uint64_t number = big_endian(rest, 3, 8);
    const uint64_t epoch = number >> 48;
    const size_t length = kRecordHeaderBytes + big_endian(rest, 11, 2);
    if (length > rest.size() || epoch > 1) return {};
    if (type != kChangeCipherSpec && type != kHandshake && type != kApplicationData) return {};
    if (epoch == 1 && (type == kChangeCipherSpec || length < kRecordOverheadBytes)) return {};
    if (epoch == 0 && type == kApplicationData) return {};
    if (records == 0) result.record_number = number;
    sealed += epoch;
    has_data |= type == kApplicationData;
    if (type == kHandshake && epoch == 0 && length > kRecordHeaderBytes &&
        byte_at(rest, kRecordHeaderBytes) == kClientHello) {
      has_hello = true;
      if (!read_client_hello(rest.first(length), result)) return {};
    }
    at += length;
  }
  if (records == 0 || sealed > 1 || ((has_data || has_hello) && records != 1)) return {};
  result.has_sealed = sealed != 0;
  result.kind = has_data ? Kind::data : has_hello ? Kind::client_hello : Kind::handshake;
  return result;
}

}  // namespace fire3dv::transport::udp
