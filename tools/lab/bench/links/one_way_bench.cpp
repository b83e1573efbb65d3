#include "tools/lab/bench/links/link_benches.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "base/clock.h"
#include "tools/lab/bench/processes.h"
#include "tools/lab/bench/report/statistics.h"

namespace fire3dv::bench {
namespace {

using fire3dv::kMillisecondNs;
using fire3dv::monotonic_ns;

constexpr int64_t kHangNs = 20 * fire3dv::kSecondNs;

[[noreturn]] void be_receiver(const Way& way, WayBoard& board) {
  pin_to_core(1);
  auto receiver = way.make_receiver(board);
  if (!receiver) {
    std::fprintf(stderr, "fire3dv-bench: %s\n", receiver.error().message.c_str());
    ::_exit(1);
  }
  board.ready = true;
  while (true) {
    // A spinning receiver yields its core while another transport is measured.
    if (!board.active) {
      ::usleep(200);
      if (!board.active) continue;
    }
    (*receiver)->receive(board);
  }
}

// Both ends of a transport, with its measurements.
struct Lane {
  Way way;
  std::unique_ptr<Shared<WayBoard>> board = std::make_unique<Shared<WayBoard>>();
  std::unique_ptr<Process> process;
  std::unique_ptr<Sender> sender;
  uint32_t next = 1;
  struct Times {
    std::vector<double> all_ns, of_round;  // of_round: medians
    void add(const std::vector<double>& round) {
      all_ns.insert(all_ns.end(), round.begin(), round.end());
      of_round.push_back(summarise(round).median);
    }
  };
  Times call, came, seen;
  uint64_t sent = 0, lost = 0;
};

bool wait_for(const std::function<bool()>& holds) {
  for (const int64_t until = monotonic_ns() + kHangNs; !holds();) {
    if (monotonic_ns() > until) return false;
    ::usleep(500);
  }
  return true;
}

Result<void> start(Lane& lane) {
  WayBoard& board = **lane.board;
  lane.process = std::make_unique<Process>([&] { be_receiver(lane.way, board); });
  if (!wait_for([&] { return board.ready || !lane.process->alive(); }) || !board.ready)
    return Error{lane.way.name + ": the receiver did not start"};
  return {};
}

Result<void> connect(Lane& lane) {
  auto sender = lane.way.make_sender(**lane.board);
  if (!sender) return sender.error();
  lane.sender = std::move(*sender);
  WayBoard& board = **lane.board;
  board.active = true;
  const bool came = wait_for([&] {
    lane.sender->prepare(0);
    lane.sender->send();
    return board.seen[0] != 0;
  });
  board.active = false;
  if (!came) return Error{lane.way.name + ": nothing comes through"};
  return {};
}

// Keeps the sender's core busy, like a simulator that computes between steps.
void spin_until(int64_t until_ns) {
  while (monotonic_ns() < until_ns) {
  }
}

void take_turn(Lane& lane, const OneWayOptions& options) {
  WayBoard& board = **lane.board;
  board.active = true;
  ::usleep(1000);  // until the receiver is active
  const auto every_ns = static_cast<int64_t>(1e9 / options.rate_hz);
  std::vector<double> calls, came, seen;
  std::vector<std::pair<uint32_t, int64_t>> sent;
  int64_t due_ns = monotonic_ns();
  for (int i = 0; i < options.frames; ++i) {
    const uint32_t index = lane.next++ % kMaxFrames;
    board.seen[index] = 0;
    lane.sender->prepare(index);
    spin_until(due_ns);
    const int64_t begin_ns = monotonic_ns();
    due_ns =
        begin_ns + every_ns;  // late frames are not caught up, since back-to-back frames would count as one
    lane.sender->send();
    calls.push_back(static_cast<double>(monotonic_ns() - begin_ns));
    sent.emplace_back(index, begin_ns);
  }
  spin_until(monotonic_ns() + 5 * kMillisecondNs);  // until the last frame arrives
  board.active = false;
  for (const auto& [index, begin_ns] : sent) {
    if (board.seen[index] == 0) {
      ++lane.lost;
      continue;
    }
    came.push_back(static_cast<double>(board.came[index] - begin_ns));
    seen.push_back(static_cast<double>(board.seen[index] - begin_ns));
  }
  lane.sent += sent.size();
  lane.call.add(calls);
  lane.came.add(came);
  lane.seen.add(seen);
}

std::string cells(const Lane::Times& times, const Lane::Times& baseline) {
  std::vector<double> ratios;
  for (size_t round = 0; round < times.of_round.size(); ++round)
    if (baseline.of_round[round] > 0) ratios.push_back(times.of_round[round] / baseline.of_round[round]);
  const Summary summary = summarise(times.all_ns);
  char text[96];
  std::snprintf(text, sizeof text, " %.2f | %.2f | %.2f |", summary.median / 1e3, summary.p99 / 1e3,
                summarise(ratios).median);
  return text;
}

void print(const std::vector<std::unique_ptr<Lane>>& lanes) {
  std::printf(
      "| way | call us | p99 | ratio | came us | p99 | ratio | in hand us | p99 | ratio | not seen |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  const Lane* baseline = nullptr;
  for (const auto& lane : lanes) {
    if (lane->way.baseline) baseline = lane.get();
    std::printf("| %s |%s%s%s %llu of %llu |\n", lane->way.name.c_str(),
                cells(lane->call, baseline->call).c_str(), cells(lane->came, baseline->came).c_str(),
                cells(lane->seen, baseline->seen).c_str(), static_cast<unsigned long long>(lane->lost),
                static_cast<unsigned long long>(lane->sent));
  }
}

std::vector<Way> ways_of(const OneWayOptions& options) {
  const std::string name = "shm://bench-way-" + std::to_string(::getpid());
  std::vector<Way> ways{bare_slot(), link_way("shm://", name), bare_tcp(),
                        link_way("tcp://", "tcp://127.0.0.1:0")};
  if (!options.security.tls_certificate_file.empty())
    ways.push_back(link_way("tls://", "tls://localhost:0", options.security));
  ways.push_back(bare_udp());
  ways.push_back(link_way("udp://", "udp://127.0.0.1:0"));
  if (!options.security.udp_key_file.empty())
    ways.push_back(link_way("udp:// with a key", "udp://127.0.0.1:0", options.security));
  return ways;
}

}  // namespace

int one_way_bench(const OneWayOptions& options) {
  std::vector<std::unique_ptr<Lane>> lanes;
  for (Way& way : ways_of(options)) {
    lanes.push_back(std::make_unique<Lane>());
    lanes.back()->way = std::move(way);
  }
  const auto fail = [](const Error& error) {
    std::fprintf(stderr, "fire3dv-bench: %s\n", error.message.c_str());
    return 1;
  };
  const bool use_own_cores = usable_cores() > 1;
  // All receivers are forked before the senders' links start threads.
  for (auto& lane : lanes)
    if (auto started = start(*lane); !started) return fail(started.error());
  pin_to_core(0);
  for (auto& lane : lanes)
    if (auto connected = connect(*lane); !connected) return fail(connected.error());
  for (int round = 0; round < options.rounds; ++round)
    for (auto& lane : lanes) take_turn(*lane, options);
  std::printf(
      "%zu poses a frame at %.0f Hz, %d rounds of %d frames, all ways in turns; the sender spins between "
      "frames. "
      "A reader of shared memory spins, one of the network waits. %s\n\n",
      kOneWayPoses, options.rate_hz, options.rounds, options.frames,
      use_own_cores ? "Each end has a core of its own." : "Both ends share one core.");
  print(lanes);
  return 0;
}

}  // namespace fire3dv::bench
