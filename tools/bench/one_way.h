// A frame's way from one process to another, by any means: what a sender and a receiver have to do.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "protocol/error.h"

namespace fire3dv::bench {

constexpr size_t kOneWayPoses = 100;
constexpr size_t kOneWayBytes = kOneWayPoses * 48;
constexpr uint32_t kMostFrames = 1 << 16;

// In memory that both processes share.
struct WayBoard {
  std::atomic<bool> ready, active;         // active: it is this way's turn
  char address[128];                       // where the receiver listens
  std::atomic<int64_t> came[kMostFrames];  // when frame i was with the receiver's process
  std::atomic<int64_t> seen[kMostFrames];  // when it was in the hands of the caller
};

struct Sender {
  virtual ~Sender() = default;
  virtual void prepare(uint32_t index) = 0;  // not timed
  virtual void send() = 0;
};

struct Receiver {
  virtual ~Receiver() = default;
  // Looks for frames, or waits for them a while; writes the times at which they had come.
  virtual void receive(WayBoard& board) = 0;
};

// How frames get across. Receivers are made in the process that receives, and write their address on the
// board.
struct Way {
  std::string name;
  bool baseline = false;  // those that follow are compared with it
  std::function<Result<std::unique_ptr<Receiver>>(WayBoard&)> make_receiver;
  std::function<Result<std::unique_ptr<Sender>>(WayBoard&)> make_sender;
};

// Bare ones: a ring's slot in shared memory, and sockets by Asio.
Way bare_slot();
Way bare_tcp();
Way bare_udp();

// Over a link; `options` are of the network's protection.
struct LinkSecurity {
  std::string udp_key_file, tls_certificate_file, tls_key_file;
};
Way link_way(const std::string& name, const std::string& uri, const LinkSecurity& security = {});

}  // namespace fire3dv::bench
