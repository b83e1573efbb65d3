// Addresses of links: their URIs, and the Internet addresses of their sockets with name lookup, listening
// sockets and loopback detection.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/unique_fd.h"

namespace fire3dv::transport {

// Link URIs: shm://NAME, tcp://HOST:PORT, tls://HOST:PORT, udp://HOST:PORT (IPv6 hosts in brackets). udp://
// accepts options: udp://HOST:PORT?mtu=8952&parity=20&ttl=4&interface=eth0.
struct Uri {
  enum class Scheme { shm, tcp, tls, udp };
  Scheme scheme = Scheme::shm;
  std::string name;   // shm: 1 to 64 characters of [A-Za-z0-9_.-], not starting with a dot
  std::string host;   // other schemes: as written, without brackets
  uint16_t port = 0;  // other schemes: 0 lets a listener choose

  // udp only; 0 or empty: not given.
  uint16_t mtu = 0;  // maximum datagram size in bytes
  // Parity datagrams in percent of the pose datagrams, 0: none. Nothing: as the measured loss demands.
  std::optional<uint8_t> parity_percent;
  uint8_t ttl = 0;        // multicast: time to live
  std::string interface;  // multicast: interface name
  bool operator==(const Uri&) const = default;
};

// The error names the URI, its fault and the valid forms.
Result<Uri> parse_uri(std::string_view text);

struct Address {
  sockaddr_storage storage{};
  socklen_t length = 0;

  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
  sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
  int family() const { return storage.ss_family; }
  bool is_loopback() const;
  uint16_t port() const;
  std::string text() const;  // "127.0.0.1:7345", "[::1]:7345"
  bool operator==(const Address& other) const;
  // Ignores the port. All addresses of an IPv6 /64 network count as one host, which can choose among them.
  bool is_same_host(const Address& other) const;
};

struct AddressHash {
  size_t operator()(const Address& address) const;
};

// "tcp://HOST:PORT" with IPv6 brackets and the given options.
std::string uri_text(const Uri& uri);

// Asynchronous name lookup: an unresponsive name server never blocks the caller.
class Lookup {
 public:
  explicit Lookup(const Uri& uri);
  // Numeric addresses only: completes immediately, without addresses for a host name.
  struct NumericOnly {};
  Lookup(const Uri& uri, NumericOnly);
  bool done() const;
  // Valid when done(): the addresses, or none with the reason in problem().
  std::vector<Address> addresses() const;
  std::string problem() const;

 private:
  struct Answer;
  std::shared_ptr<Answer> answer_;
};

struct BoundSocket {
  UniqueFd fd;
  Address address;  // with the assigned port
};
// Binds a non-blocking socket to the URI's address; `type` is SOCK_STREAM (listening) or SOCK_DGRAM.
// may_be_public: allows addresses other than loopback, because peers are authenticated or the user allowed
// it.
Result<BoundSocket> bind_listener(const Uri& uri, int type, bool may_be_public);

}  // namespace fire3dv::transport
