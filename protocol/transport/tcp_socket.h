// Options that every TCP connection of ours has.
#pragma once

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include "protocol/transport/address.h"

namespace fire3dv::transport::tcp {

// What the kernel keeps unsent is older than what could be sent in its place: over a slow link it would be
// seconds.
constexpr int kMostUnsentInKernelBytes = 16 << 10;

// A peer that vanishes without a word (cable, power) is noticed by the kernel within about 10 seconds.
inline void tune_socket(int fd) {
  const auto set = [fd](int level, int option, int value) {
    ::setsockopt(fd, level, option, &value, sizeof value);
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(IPPROTO_TCP, TCP_NOTSENT_LOWAT, kMostUnsentInKernelBytes);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 4);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 2);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, 10'000);
}

// A client that tries a free port of its own machine long enough is at last given that very port as its own,
// and is connected to itself; it would then keep the real listener from binding it.
inline bool connected_to_itself(int fd) {
  Address own, other;
  own.length = other.length = sizeof own.storage;
  return ::getsockname(fd, own.get(), &own.length) == 0 &&
         ::getpeername(fd, other.get(), &other.length) == 0 && own == other;
}

}  // namespace fire3dv::transport::tcp
