#include "tools/lab/bench/links/link_benches.h"

#include <poll.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <vector>

#include "protocol/base/clock.h"
#include "tools/lab/bench/links/simulator.h"
#include "tools/lab/bench/report/statistics.h"

namespace fire3dv::bench {
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

void sleep_until(int64_t until_ns) {
  const timespec until{until_ns / fire3dv::kSecondNs, until_ns % fire3dv::kSecondNs};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
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
