// One-way latency interfaces: sender, receiver and the shared memory board of a transport under test. Times
// are monotonic nanoseconds.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "protocol/base/error.h"

namespace fire3dv::bench {

constexpr size_t kOneWayPoses = 100;
constexpr size_t kOneWayBytes = kOneWayPoses * 48;
constexpr uint32_t kMaxFrames = 1 << 16;

// Shared memory of sender and receiver process.
struct WayBoard {
  std::atomic<bool> ready, active;        // active: this transport is being measured
  char address[128];                      // URI or port of the receiver
  std::atomic<int64_t> came[kMaxFrames];  // frame i has reached the receiver's process
  std::atomic<int64_t> seen[kMaxFrames];  // the receiver has returned frame i to its caller
};

struct Sender {
  virtual ~Sender() = default;
  virtual void prepare(uint32_t index) = 0;  // not timed
  virtual void send() = 0;
};

struct Receiver {
  virtual ~Receiver() = default;
  // Polls, or waits briefly; writes arrival times.
  virtual void receive(WayBoard& board) = 0;
};

// Transport under test. Receivers are created in the receiving process and write their address to the board.
struct Way {
  std::string name;
  bool baseline = false;  // later ones are compared with it
  std::function<Result<std::unique_ptr<Receiver>>(WayBoard&)> make_receiver;
  std::function<Result<std::unique_ptr<Sender>>(WayBoard&)> make_sender;
};

// Baselines: a ring slot in shared memory, and Asio sockets.
Way bare_slot();
Way bare_tcp();
Way bare_udp();

// Security options of network links.
struct LinkSecurity {
  std::string udp_key_file, tls_certificate_file, tls_key_file;
};
Way link_way(const std::string& name, const std::string& uri, const LinkSecurity& security = {});

}  // namespace fire3dv::bench
