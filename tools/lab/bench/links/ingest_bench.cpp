#include "tools/lab/bench/links/link_benches.h"

#include <sys/resource.h>

#include <atomic>
#include <cstdio>

#include "base/clock.h"
#include "renderer/streams/stream_receiver.h"
#include "tools/lab/bench/links/simulator.h"
#include "tools/lab/bench/processes.h"

namespace fire3dv::bench {
namespace {

using fire3dv::monotonic_ns;

struct Board {
  std::atomic<bool> ready, failed, counting, done;
  char address[128];
  uint64_t poses, frames;  // set before done
  double wall_s, cpu_s;
};

double cpu_seconds() {
  rusage use{};
  ::getrusage(RUSAGE_SELF, &use);
  return static_cast<double>(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
         static_cast<double>(use.ru_utime.tv_usec + use.ru_stime.tv_usec) / 1e6;
}

scene::Scene scene_of_bodies(size_t count) {
  scene::Scene scene;
  for (std::string& name : body_names(count)) {
    scene::Node node;
    node.path = node.name = std::move(name);
    scene.nodes.push_back(std::move(node));
  }
  return scene;
}

uint64_t newest_sequence(const state::PoseState& poses) {
  return poses.streams().empty() ? 0 : poses.streams().front().header.sequence;
}

// Runs the renderer's receiver and the link's threads on one core.
void poll_streams(Board& board, const std::string& uri, size_t count, double seconds) {
  pin_to_core(1);
  const scene::Scene scene = scene_of_bodies(count);
  state::PoseState poses(scene);
  app::PlayOptions play;
  play.mode = app::PlayOptions::Mode::latest;
  app::StreamReceiver receiver(poses, false, play);
  auto link = transport::open_listener(uri);
  if (!link) {
    std::fprintf(stderr, "fire3dv-bench: %s\n", link.error().message.c_str());
    board.failed = true;
    return;
  }
  std::snprintf(board.address, sizeof board.address, "%s", (*link)->uri().c_str());
  receiver.add(std::move(*link));
  board.ready = true;
  while (!receiver.poll()) receiver.wait(std::chrono::milliseconds(1));
  board.counting = true;

  const int64_t begin_ns = monotonic_ns();
  const auto until_ns = begin_ns + static_cast<int64_t>(seconds * 1e9);
  const double cpu_before = cpu_seconds();
  uint64_t frames = 0, last = newest_sequence(poses);
  while (monotonic_ns() < until_ns) {
    receiver.wait(std::chrono::milliseconds(1));
    if (!receiver.poll()) continue;
    const uint64_t sequence = newest_sequence(poses);
    frames += sequence != last;
    last = sequence;
  }
  board.frames = frames;
  board.poses = frames * count;
  board.cpu_s = cpu_seconds() - cpu_before;
  board.wall_s = static_cast<double>(monotonic_ns() - begin_ns) / 1e9;
  board.done = true;
}

bool measure(const char* name, const std::string& uri, size_t count, const IngestOptions& options) {
  Shared<Board> board;
  Process reader([&] {
    poll_streams(*board, uri, count, options.seconds);
    while (true) ::pause();
  });
  while (!board->ready && !board->failed) ::usleep(500);
  if (board->failed) return false;
  uint64_t published = 0, published_before = 0;
  std::thread writer([&] {
    pin_to_core(0);
    auto simulator = Simulator::open(board->address, count);
    if (!simulator) {
      std::fprintf(stderr, "fire3dv-bench: %s\n", simulator.error().message.c_str());
      board->failed = true;
      return;
    }
    std::vector<std::byte> reply;
    while (!board->done) {
      (*simulator)->publish();
      ++published;
      if (!board->counting) published_before = published;
      (*simulator)->link().poll(reply);
    }
  });
  writer.join();
  if (board->failed) return false;
  const double poses = static_cast<double>(board->poses);
  std::printf("| %s | %zu | %.2f | %.2f | %.0f %% | %.0f %% |\n", name, count, poses / board->wall_s / 1e6,
              poses / board->cpu_s / 1e6, 100 * board->cpu_s / board->wall_s,
              100 * static_cast<double>(board->frames) /
                  static_cast<double>(std::max<uint64_t>(published - published_before, 1)));
  std::fflush(stdout);
  return true;
}

}  // namespace

int ingest_bench(const IngestOptions& options) {
  const std::string shm = "shm://bench-ingest-" + std::to_string(::getpid());
  std::printf(
      "A simulator publishes as fast as it can; the renderer's receiver runs with its link's threads on one "
      "core, "
      "the simulator on another. Frames that were overtaken before they were read do not count. %.1f s a "
      "row.\n\n"
      "| link | poses a frame | million poses/s | of CPU time | core busy | of the frames published |\n"
      "|---|---|---|---|---|---|\n",
      options.seconds);
  for (const size_t count : {size_t{100}, size_t{1000}, size_t{10000}}) {
    if (!measure("shm://", shm, count, options) || !measure("tcp://", "tcp://127.0.0.1:0", count, options) ||
        !measure("udp://", "udp://127.0.0.1:0", count, options))
      return 1;
  }
  return 0;
}

}  // namespace fire3dv::bench
