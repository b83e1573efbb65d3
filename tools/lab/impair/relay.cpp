#include "tools/lab/impair/relay.h"

#include "protocol/transport/core/uri.h"
#include "tools/lab/impair/tcp_relay.h"
#include "tools/lab/impair/udp_relay.h"

namespace fire3dv::impair {

Result<std::unique_ptr<Relay>> open_relay(const std::string& from, const std::string& to,
                                          const Impairment& impairment, bool may_be_public) {
  using Scheme = transport::Uri::Scheme;
  const auto from_uri = transport::parse_uri(from);
  if (!from_uri) return from_uri.error();
  const auto to_uri = transport::parse_uri(to);
  if (!to_uri) return to_uri.error();
  if (from_uri->scheme == Scheme::shm || to_uri->scheme == Scheme::shm)
    return Error{"shared memory uses no network: name udp://, tcp:// or tls:// addresses"};
  if ((from_uri->scheme == Scheme::udp) != (to_uri->scheme == Scheme::udp))
    return Error{from + " and " + to + ": name two URIs of one kind, datagrams or streams"};
  if (to_uri->port == 0) return Error{to + ": port 0 is for listeners; name the target's port"};
  const auto open = [&](auto opened) -> Result<std::unique_ptr<Relay>> {
    if (!opened) return opened.error();
    return std::unique_ptr<Relay>(std::move(*opened));
  };
  if (from_uri->scheme == Scheme::udp) return open(UdpRelay::open(from, to, impairment, may_be_public));
  return open(TcpRelay::open(from, to, impairment, may_be_public));
}

Result<RelayEnds> open_ends(const std::string& from, const std::string& to, int type, bool may_be_public) {
  auto from_uri = transport::parse_uri(from);
  if (!from_uri) return from_uri.error();
  const auto to_uri = transport::parse_uri(to);
  if (!to_uri) return to_uri.error();
  const transport::Lookup lookup(*to_uri);
  if (!lookup.done()) return Error{to + ": name the target by its address, in digits"};
  auto bound = transport::bind_listener(*from_uri, type, may_be_public);
  if (!bound) return bound.error();
  from_uri->port = bound->address.port();
  return RelayEnds{transport::uri_text(*from_uri), std::move(bound->fd), lookup.addresses().front()};
}

}  // namespace fire3dv::impair
