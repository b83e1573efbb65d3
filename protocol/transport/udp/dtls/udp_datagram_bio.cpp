#include "protocol/transport/udp/dtls/udp_datagram_bio.h"

#include <openssl/bio.h>

#include <algorithm>
#include <cstring>
#include <exception>

namespace fire3dv::transport::udp {
namespace {

constexpr std::byte kAlert{21}, kApplicationData{23};
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
  if (data[0] == kAlert) return length;
  if (data[0] == kApplicationData) {
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
