#include "tools/lab/impair/relay_sockets.h"

#include "protocol/transport/core/uri.h"

namespace fire3dv::impair {

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
