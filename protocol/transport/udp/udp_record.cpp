#include "protocol/transport/udp/udp_record.h"

#include <openssl/bio.h>

#include <algorithm>
#include <cstring>
#include <exception>

namespace fire3dv::transport::udp {
namespace {

constexpr unsigned kChangeCipherSpec = 20, kAlert = 21, kHandshake = 22, kApplicationData = 23;
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

namespace {

constexpr size_t kMaxOutgoing = 16;  // a flight has at most three
constexpr long kIpv6AndUdpBytes = 48;

DatagramEnds& ends_of(BIO* bio) {
  return *static_cast<DatagramEnds*>(::BIO_get_data(bio));
}

int read_datagram(BIO* bio, char* to, int room) {
  DatagramEnds& ends = ends_of(bio);
  BIO_clear_retry_flags(bio);
  if (ends.incoming.empty()) {
    BIO_set_retry_read(bio);
    return -1;
  }
  // Truncates like recv(2).
  const size_t bytes = std::min(ends.incoming.size(), static_cast<size_t>(std::max(room, 0)));
  std::memcpy(to, ends.incoming.data(), bytes);
  ends.incoming = {};
  return static_cast<int>(bytes);
}

// OpenSSL is C: no exception may pass through it.
int write_datagram(BIO* bio, const char* from, int length) {
  DatagramEnds& ends = ends_of(bio);
  BIO_clear_retry_flags(bio);
  if (length <= 0) return length;
  const auto* const data = reinterpret_cast<const std::byte*>(from);
  const auto bytes = static_cast<size_t>(length);
  if (data[0] == std::byte{kAlert}) return length;
  if (data[0] == std::byte{kApplicationData}) {
    if (bytes > ends.sealed.size()) return -1;
    std::memcpy(ends.sealed.data(), data, bytes);
    ends.sealed_bytes = bytes;
    return length;
  }
  if (ends.outgoing.size() >= kMaxOutgoing) return length;  // dropped, like a datagram lost on the network
  try {
    ends.outgoing.emplace_back(data, data + bytes);
  } catch (const std::exception&) {
    return -1;
  }
  return length;
}

long control(BIO* bio, int command, long, void*) {
  switch (command) {
    case BIO_CTRL_FLUSH:
      return 1;
    case BIO_CTRL_PENDING:
      return static_cast<long>(ends_of(bio).incoming.size());
    case BIO_CTRL_DGRAM_GET_MTU_OVERHEAD:
      return kIpv6AndUdpBytes;
    default:
      return 0;
  }
}

int create(BIO* bio) {
  ::BIO_set_init(bio, 1);
  return 1;
}

BIO_METHOD* make_method() {
  const int index = ::BIO_get_new_index();
  if (index == -1) return nullptr;
  BIO_METHOD* const method = ::BIO_meth_new(index | BIO_TYPE_SOURCE_SINK, "single datagrams");
  if (method == nullptr) return nullptr;
  ::BIO_meth_set_create(method, create);
  ::BIO_meth_set_read(method, read_datagram);
  ::BIO_meth_set_write(method, write_datagram);
  ::BIO_meth_set_ctrl(method, control);
  return method;
}

}  // namespace

BIO* make_datagram_bio(DatagramEnds& ends) {
  static BIO_METHOD* const method = make_method();  // process lifetime, like OpenSSL's own methods
  if (method == nullptr) return nullptr;
  BIO* const bio = ::BIO_new(method);
  if (bio != nullptr) ::BIO_set_data(bio, &ends);
  return bio;
}

}  // namespace fire3dv::transport::udp
