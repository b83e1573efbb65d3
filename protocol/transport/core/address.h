// Internet addresses: name lookup, listening sockets and loopback detection.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/base/unique_fd.h"
#include "protocol/transport/core/uri.h"

namespace fire3dv::transport {

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
