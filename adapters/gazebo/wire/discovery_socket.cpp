#include "adapters/gazebo/wire/discovery_socket.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "adapters/gazebo/wire/discovery.h"
#include "base/text.h"

namespace fire3dv::gazebo {
namespace {

constexpr size_t kMaxDatagramBytes = 65536;
constexpr size_t kMaxRelays = 64;  // hosts add themselves

sockaddr_in address_of(const std::string& ip, uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  inet_pton(AF_INET, ip.c_str(), &address.sin_addr);
  return address;
}

std::string text_of(const in_addr& address) {
  char text[INET_ADDRSTRLEN] = "";
  inet_ntop(AF_INET, &address, text, sizeof text);
  return text;
}

void send_to(int fd, std::span<const std::byte> datagram, const sockaddr_in& to) {
  // A datagram may get lost on any path; it is repeated every second.
  (void)::sendto(fd, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                 reinterpret_cast<const sockaddr*>(&to), sizeof to);
}

Error system_error(const std::string& action) {
  return Error{action + ": " + std::strerror(errno)};
}

}  // namespace

std::vector<std::string> interface_addresses() {
  std::vector<std::string> addresses, loopback;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {"127.0.0.1"};
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owner(list, &::freeifaddrs);
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || entry->ifa_addr->sa_family != AF_INET || !(entry->ifa_flags & IFF_UP)) continue;
    sockaddr_in address{};
    std::memcpy(&address, entry->ifa_addr, sizeof address);
    ((entry->ifa_flags & IFF_LOOPBACK) ? loopback : addresses).push_back(text_of(address.sin_addr));
  }
  addresses.insert(addresses.end(), loopback.begin(), loopback.end());
  if (addresses.empty()) addresses.push_back("127.0.0.1");
  return addresses;
}

Result<std::string> resolve_host(const std::string& host) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), nullptr, &hints, &found); error != 0)
    return Error{"no IPv4 address is known for host " + quote(host) + ": " + gai_strerror(error)};
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  sockaddr_in address{};
  std::memcpy(&address, found->ai_addr, sizeof address);
  return text_of(address.sin_addr);
}

std::string local_address_to(const std::string& remote) {
  const Descriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in to = address_of(remote, kMessagePort), from{};
  socklen_t size = sizeof from;
  // Connecting a UDP socket sends nothing.
  if (socket.get() < 0 || ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0 ||
      ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&from), &size) != 0)
    return "";
  return text_of(from.sin_addr);
}

Descriptor::~Descriptor() {
  if (fd_ >= 0) ::close(fd_);
}
Descriptor::Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

Result<DiscoverySocket> DiscoverySocket::open(uint16_t port, const std::vector<std::string>& interfaces) {
  DiscoverySocket socket;
  socket.port_ = port;
  socket.buffer_.resize(kMaxDatagramBytes);
  socket.receiver_ = Descriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int receiver = socket.receiver_.get();
  if (receiver < 0) return system_error("cannot open a socket for Gazebo's discovery");
  const int on = 1;
  // All processes of this host that speak Gazebo Transport share the port.
  (void)::setsockopt(receiver, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  (void)::setsockopt(receiver, SOL_SOCKET, SO_REUSEPORT, &on, sizeof on);
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_ANY);
  any.sin_port = htons(port);
  if (::bind(receiver, reinterpret_cast<const sockaddr*>(&any), sizeof any) != 0)
    return system_error("cannot bind UDP port " + std::to_string(port) + " of Gazebo's discovery");
  std::string reasons;
  for (const std::string& ip : interfaces) {
    ip_mreq group{};
    inet_pton(AF_INET, kMulticastGroup, &group.imr_multiaddr);
    Descriptor sender(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const bool is_address = inet_pton(AF_INET, ip.c_str(), &group.imr_interface) == 1;
    errno = is_address ? errno : EINVAL;
    if (!is_address || sender.get() < 0 ||
        ::setsockopt(sender.get(), IPPROTO_IP, IP_MULTICAST_IF, &group.imr_interface,
                     sizeof group.imr_interface) != 0 ||
        ::setsockopt(receiver, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0) {
      reasons += (reasons.empty() ? "" : ", ") + ip + ": " + std::strerror(errno);
      continue;
    }
    socket.senders_.push_back(std::move(sender));
  }
  if (socket.senders_.empty())
    return Error{std::string("cannot join the multicast group ") + kMulticastGroup + " (" + reasons +
                 "): is the interface up, and is the address one of this host (--ip, GZ_IP)?"};
  return socket;
}

void DiscoverySocket::send_to_group(std::span<const std::byte> datagram) const {
  for (const Descriptor& sender : senders_)
    send_to(sender.get(), datagram, address_of(kMulticastGroup, port_));
}

void DiscoverySocket::send_to_relays(std::span<const std::byte> datagram) const {
  for (const std::string& relay : relays_) send_to(receiver_.get(), datagram, address_of(relay, port_));
}

void DiscoverySocket::add_relay(const std::string& address) {
  if (relays_.size() < kMaxRelays && std::find(relays_.begin(), relays_.end(), address) == relays_.end())
    relays_.push_back(address);
}

std::optional<DiscoverySocket::Datagram> DiscoverySocket::receive() {
  sockaddr_in from{};
  socklen_t from_size = sizeof from;
  ssize_t size = 0;
  do {
    size = ::recvfrom(receiver_.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT,
                      reinterpret_cast<sockaddr*>(&from), &from_size);
  } while (size < 0 && errno == EINTR);
  if (size < 0) return std::nullopt;
  return Datagram{std::span(buffer_).first(static_cast<size_t>(size)), text_of(from.sin_addr)};
}

}  // namespace fire3dv::gazebo
