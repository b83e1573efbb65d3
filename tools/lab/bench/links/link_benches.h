// Benchmarks of links, one function per command of fire3dv-bench, and the transports of the one-way
// benchmark. Each benchmark prints tables in Markdown and returns the exit code.
#pragma once

#include <time.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "base/clock.h"
#include "base/error.h"

namespace fire3dv::bench {

// One-way latency interfaces: sender, receiver and the shared memory board of a transport under test. Times
// are monotonic nanoseconds.

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

// Cost of a publish over shared memory, against a bare copy of the same bytes.
int publish_bench(int rounds);

struct OneWayOptions {
  int rounds = 31;
  int frames = 100;  // consecutive frames per transport and turn
  double rate_hz = 1000;
  LinkSecurity security;  // links without key files are skipped
};

// Cost of a publish and arrival time of its frame for each link, against the simplest transport of the same
// kind.
int one_way_bench(const OneWayOptions& options);

// Cost of an image request without a wait, against publishing a frame.
int request_bench(int rounds);

struct PublishOptions {
  std::string uri;
  size_t poses = 100;
  double rate_hz = 1000;
};

// Scripted publisher at a fixed rate. Runs until end of input. For each input line it prints a JSON line
// about the calls since the last one: count, percentiles in nanoseconds, drops, readers.
int publish_command(const PublishOptions& options);

struct IngestOptions {
  double seconds = 2;  // per row
};

// Poses per second that a renderer receives, decodes, checks and binds to nodes.
int ingest_bench(const IngestOptions& options);

// Waits until a time of base/clock.h.
inline void sleep_until(int64_t until_ns) {
  const timespec until{until_ns / kSecondNs, until_ns % kSecondNs};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

}  // namespace fire3dv::bench
