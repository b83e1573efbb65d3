// Socket options of all TCP connections.
#pragma once

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include "protocol/transport/core/address.h"

namespace fire3dv::transport::tcp {

// Limit of unsent bytes in the kernel. Newer poses cannot replace these bytes, which would amount to seconds
// on a slow link.
constexpr int kMaxUnsentInKernelBytes = 16 << 10;

// Sets the options. The kernel detects a vanished peer (cable, power) within about 10 seconds.
inline void tune_socket(int fd) {
  const auto set = [fd](int level, int option, int value) {
    ::setsockopt(fd, level, option, &value, sizeof value);
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(IPPROTO_TCP, TCP_NOTSENT_LOWAT, kMaxUnsentInKernelBytes);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 4);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 2);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, 10'000);
}

// True for a TCP self-connection: a client that retries an unused local port may get that port as its own. It
// would prevent the real listener from binding it.
inline bool connected_to_itself(int fd) {
  Address own, other;
  own.length = other.length = sizeof own.storage;
  return ::getsockname(fd, own.get(), &own.length) == 0 &&
         ::getpeername(fd, other.get(), &other.length) == 0 && own == other;
}

}  // namespace fire3dv::transport::tcp
