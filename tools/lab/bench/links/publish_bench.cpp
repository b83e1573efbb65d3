#include <poll.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "protocol/transport/open.h"
#include "protocol/wire/check.h"
#include "protocol/wire/encode.h"
#include "tools/lab/bench/links/link_benches.h"
#include "tools/lab/bench/links/simulator.h"
#include "tools/lab/bench/report/statistics.h"

namespace fire3dv::bench {

namespace {

constexpr size_t kPublishSlots = 8;
constexpr size_t kSlotBytes = 64 << 10;
constexpr int kCallsPerRound = 200;

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

double ns_per_call(const std::function<void()>& call) {
  const int64_t start = fire3dv::monotonic_ns();
  for (int i = 0; i < kCallsPerRound; ++i) call();
  return static_cast<double>(fire3dv::monotonic_ns() - start) / kCallsPerRound;
}

struct Method {
  const char* name;
  std::function<void()> call;
  std::vector<double> ns, ratio;
};

}  // namespace

// All variants alternate, so that other load affects all of them. Ratios are taken per round.
int publish_bench(int rounds) {
  std::printf(
      "One publish over shm://, spinning publisher, no reader; medians of %d rounds of %d calls.\n\n"
      "| poses | way | ns a call | ratio |\n|---|---|---|---|\n",
      rounds, kCallsPerRound);
  for (const size_t count : {size_t{1}, size_t{100}, size_t{1000}}) {
    const std::string name = "bench-" + std::to_string(::getpid());
    auto link = transport::open_publisher("shm://" + name);
    if (!link) {
      std::fprintf(stderr, "fire3dv-bench: %s\n", link.error().message.c_str());
      return 1;
    }
    std::vector<wire::Affine3x4> poses(count);
    wire::PoseFrameEncoder encoder;
    wire::PoseFrameView frame;
    frame.header.epoch = 1;
    frame.node_count = static_cast<uint32_t>(count);
    frame.poses = poses;
    const std::span<const std::byte> bytes = std::as_bytes(std::span(poses));
    void* const memory = ::mmap(nullptr, kPublishSlots * kSlotBytes, PROT_READ | PROT_WRITE,
                                MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
    if (memory == MAP_FAILED) return 1;
    size_t slot = 0;
    void* (*volatile copy)(void*, const void*, size_t) = std::memcpy;
    Method methods[] = {
        {"memcpy into a slot of a ring",
         [&] {
           copy(static_cast<std::byte*>(memory) + slot++ % kPublishSlots * kSlotBytes, bytes.data(),
                bytes.size());
         },
         {},
         {}},
        {"link: publish", [&, pieces = encoder.encode(frame)] { (*link)->publish(pieces); }, {}, {}},
        {"client: check, encode, read the clock, publish",
         [&] {
           ++frame.header.sequence;
           frame.header.publish_time_ns = static_cast<uint64_t>(fire3dv::monotonic_ns());
           if (wire::check_poses("poses", poses, 1e12f)) (*link)->publish(encoder.encode(frame));
         },
         {},
         {}},
    };
    for (int round = 0; round < rounds; ++round) {
      for (Method& method : methods) {
        method.ns.push_back(ns_per_call(method.call));
        method.ratio.push_back(method.ns.back() / methods[0].ns.back());
      }
    }
    for (const Method& method : methods)
      std::printf("| %zu | %s | %.1f | %.2f |\n", count, method.name, median(method.ns),
                  median(method.ratio));
    ::munmap(memory, kPublishSlots * kSlotBytes);
  }
  return 0;
}

namespace {

using fire3dv::monotonic_ns;

enum class Input { nothing, line, ended };

Input poll_input() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (::poll(&input, 1, 0) <= 0) return Input::nothing;
  char bytes[256];
  const ssize_t got = ::read(STDIN_FILENO, bytes, sizeof bytes);
  if (got <= 0) return Input::ended;
  return Input::line;
}

void answer(std::vector<double>& call_ns, const transport::LinkStats& stats) {
  const Summary summary = summarise(call_ns);
  std::printf(
      "{\"calls\":%zu,\"p50_ns\":%.0f,\"p99_ns\":%.0f,\"p999_ns\":%.0f,\"max_ns\":%.0f,\"dropped\":%llu,"
      "\"renderers\":%u}\n",
      summary.count, summary.median, summary.p99, summary.p999, summary.most,
      static_cast<unsigned long long>(stats.frames_dropped), stats.peers);
  std::fflush(stdout);
  call_ns.clear();
}

}  // namespace

int publish_command(const PublishOptions& options) {
  auto simulator = Simulator::open(options.uri, options.poses);
  if (!simulator) {
    std::fprintf(stderr, "fire3dv-bench: %s\n", simulator.error().message.c_str());
    return 1;
  }
  const auto every_ns = static_cast<int64_t>(1e9 / options.rate_hz);
  std::vector<double> call_ns;
  call_ns.reserve(1 << 20);
  std::vector<std::byte> reply;
  for (int64_t due_ns = monotonic_ns();; due_ns += every_ns) {
    const Input input = poll_input();
    if (input == Input::ended) return 0;
    if (input == Input::line) answer(call_ns, (*simulator)->link().stats());
    for (int i = 0; i < 64 && (*simulator)->link().poll(reply); ++i) {
    }
    const int64_t now_ns = monotonic_ns();
    if (due_ns < now_ns - fire3dv::kSecondNs) due_ns = now_ns;  // after suspension, missed frames are skipped
    sleep_until(due_ns);
    const int64_t begin_ns = monotonic_ns();
    (*simulator)->publish();
    call_ns.push_back(static_cast<double>(monotonic_ns() - begin_ns));
  }
}

}  // namespace fire3dv::bench
