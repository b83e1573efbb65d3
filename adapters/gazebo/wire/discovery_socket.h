// UDP sockets of Gazebo's discovery: one port of the multicast group, on all interfaces of this host, and
// unicast to relays on other hosts. Never blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::gazebo {

// IPv4 addresses of this host's interfaces that are up; loopback last.
std::vector<std::string> interface_addresses();

// IPv4 address of a host name or address. Waits for the resolver.
Result<std::string> resolve_host(const std::string& host);

// Address of this host from which packets go to an IPv4 address; empty: there is no route.
std::string local_address_to(const std::string& remote);

// Owner of a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  ~Descriptor();
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  int get() const { return fd_; }

 private:
  int fd_;
};

class DiscoverySocket {
 public:
  // interfaces: addresses of this host, at least one. Those that cannot join the group are skipped; the error
  // has the reason if none can.
  static Result<DiscoverySocket> open(uint16_t port, const std::vector<std::string>& interfaces);

  int descriptor() const { return receiver_.get(); }
  // To the group, on each interface.
  void send_to_group(std::span<const std::byte> datagram) const;
  void send_to_relays(std::span<const std::byte> datagram) const;
  // address: IPv4. Ignores known ones, and more than 64.
  void add_relay(const std::string& address);

  struct Datagram {
    std::span<const std::byte> bytes;  // valid until the next call
    std::string from;                  // IPv4 address of the sender
  };
  std::optional<Datagram> receive();

 private:
  DiscoverySocket() = default;
  uint16_t port_ = 0;
  Descriptor receiver_;
  std::vector<Descriptor> senders_;  // one per interface
  std::vector<std::string> relays_;
  std::vector<std::byte> buffer_;
};

}  // namespace fire3dv::gazebo
