#include "protocol/transport/udp/udp_group_socket.h"

#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>

namespace fire3dv::transport::udp {
namespace {

bool is_group(const Address& address) {
  if (address.family() == AF_INET)
    return IN_MULTICAST(ntohl(reinterpret_cast<const sockaddr_in&>(address.storage).sin_addr.s_addr));
  return address.family() == AF_INET6 &&
         IN6_IS_ADDR_MULTICAST(&reinterpret_cast<const sockaddr_in6&>(address.storage).sin6_addr);
}

// 0: the system chooses.
Result<unsigned> interface_of(const Uri& uri, const Address& group) {
  if (!uri.interface.empty()) {
    const unsigned index = ::if_nametoindex(uri.interface.c_str());
    if (index == 0)
      return Error{uri_text(uri) + ": there is no interface '" + uri.interface + "'; `ip link` lists them"};
    return index;
  }
  if (group.family() == AF_INET6) return reinterpret_cast<const sockaddr_in6&>(group.storage).sin6_scope_id;
  return 0u;
}

Error system_error(const Uri& uri, const std::string& what) {
  return Error{uri_text(uri) + ": " + what + ": " + std::strerror(errno) +
               "; choose the interface with ?interface=NAME"};
}

template <typename Value>
bool set(int fd, int level, int option, const Value& value) {
  return ::setsockopt(fd, level, option, &value, sizeof value) == 0;
}

bool set_outgoing_interface(int fd, const Address& group, int interface, int ttl) {
  if (group.family() == AF_INET6)
    return set(fd, IPPROTO_IPV6, IPV6_MULTICAST_HOPS, ttl) &&
           (interface == 0 || set(fd, IPPROTO_IPV6, IPV6_MULTICAST_IF, interface));
  ip_mreqn request{};
  request.imr_ifindex = interface;
  return set(fd, IPPROTO_IP, IP_MULTICAST_TTL, ttl) &&
         (interface == 0 || set(fd, IPPROTO_IP, IP_MULTICAST_IF, request));
}

bool join(int fd, const Address& group, unsigned interface) {
  const int off = 0;
  if (group.family() == AF_INET6) {
    ipv6_mreq membership{};
    membership.ipv6mr_multiaddr = reinterpret_cast<const sockaddr_in6&>(group.storage).sin6_addr;
    membership.ipv6mr_interface = interface;
    return set(fd, IPPROTO_IPV6, IPV6_MULTICAST_ALL, off) &&
           set(fd, IPPROTO_IPV6, IPV6_ADD_MEMBERSHIP, membership);
  }
  ip_mreqn membership{};
  membership.imr_multiaddr = reinterpret_cast<const sockaddr_in&>(group.storage).sin_addr;
  membership.imr_ifindex = static_cast<int>(interface);
  // Excludes groups that other programs of this machine have joined.
  return set(fd, IPPROTO_IP, IP_MULTICAST_ALL, off) && set(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, membership);
}

}  // namespace

std::optional<Address> group_of(const Uri& uri) {
  const Lookup lookup(uri, Lookup::NumericOnly{});
  const std::vector<Address> found = lookup.addresses();
  if (found.empty() || !is_group(found.front())) return {};
  return found.front();
}

Result<void> refuse_group_options(const Uri& uri) {
  if (uri.ttl == 0 && uri.interface.empty()) return {};
  return Error{uri_text(uri) + ": ttl and interface are for multicast groups; leave them away"};
}

Result<UniqueFd> open_group_sender(const Uri& uri, const Address& group) {
  const Result<unsigned> interface = interface_of(uri, group);
  if (!interface) return interface.error();
  UniqueFd fd(::socket(group.family(), SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) return system_error(uri, "cannot make a socket");
  set(fd.get(), SOL_SOCKET, SO_SNDBUF, 4 << 20);
  // Default TTL 1: datagrams do not leave the network segment.
  if (!set_outgoing_interface(fd.get(), group, static_cast<int>(*interface), uri.ttl != 0 ? uri.ttl : 1))
    return system_error(uri, "cannot send to the group");
  Address to = group;
  if (to.family() == AF_INET6 && *interface != 0)
    reinterpret_cast<sockaddr_in6&>(to.storage).sin6_scope_id = *interface;
  if (::connect(fd.get(), to.get(), to.length) != 0) return system_error(uri, "cannot send to the group");
  return fd;
}

Result<UniqueFd> open_group_receiver(const Uri& uri, const Address& group) {
  const Result<unsigned> interface = interface_of(uri, group);
  if (!interface) return interface.error();
  UniqueFd fd(::socket(group.family(), SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) return system_error(uri, "cannot make a socket");
  Address at = group;
  if (at.family() == AF_INET6 && *interface != 0)
    reinterpret_cast<sockaddr_in6&>(at.storage).sin6_scope_id = *interface;
  const int on = 1;
  if (!set(fd.get(), SOL_SOCKET, SO_REUSEADDR, on) || ::bind(fd.get(), at.get(), at.length) != 0)
    return system_error(uri, "cannot listen");
  if (!join(fd.get(), group, *interface)) return system_error(uri, "cannot join the group");
  return fd;
}

}  // namespace fire3dv::transport::udp
