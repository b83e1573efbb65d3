// Internet addresses: names looked up, listening sockets bound, loopback told from the rest.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "protocol/transport/unique_fd.h"
#include "protocol/transport/uri.h"

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
};

// "tcp://HOST:PORT" with brackets where they belong, and the options that were given.
std::string uri_text(const Uri& uri);

// Looks a name up without waiting for the answer: a name server that is silent must not hold anybody up.
class Lookup {
 public:
  explicit Lookup(const Uri& uri);
  // Done at once; no addresses for what is not a number.
  struct NumbersAlone {};
  Lookup(const Uri& uri, NumbersAlone);
  bool done() const;
  // Call when done: the addresses, or none and problem() says why.
  std::vector<Address> addresses() const;
  std::string problem() const;

 private:
  struct Answer;
  std::shared_ptr<Answer> answer_;
};

struct BoundSocket {
  UniqueFd fd;
  Address address;  // with the port that was chosen
};
// A non-blocking socket bound to the URI's address; `type` is SOCK_STREAM (listening) or SOCK_DGRAM.
// may_be_public: addresses other than loopback are allowed, since strangers are kept out or are wanted.
Result<BoundSocket> bind_listener(const Uri& uri, int type, bool may_be_public);

}  // namespace fire3dv::transport
