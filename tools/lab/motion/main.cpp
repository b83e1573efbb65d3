// Motion smoothness program fire3dv-motion: `send` publishes the reference motion, `watch` listens like a
// renderer and reports the displayed error, `score` evaluates a recorded run again.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include <unistd.h>

#include "fire3dv/client.hpp"
#include "protocol/base/clock.h"
#include "protocol/base/command_line.h"
#include "protocol/transport/open.h"
#include "tools/lab/motion/reference_motion.h"
#include "tools/lab/motion/score.h"
#include "tools/lab/motion/watcher.h"
#include "tools/listener_options.h"

namespace {

using namespace fire3dv;

volatile std::sig_atomic_t stop_requested = 0;

constexpr int kUsageError = 2;

struct SendOptions {
  std::string uri, name = "motion";
  double rate_hz = 60, seconds = 0;
  uint32_t nodes = 1;
  Security security;
};

struct WatchOptions {
  std::string uri;
  double seconds = 20;
  bool as_json = false;
  std::string record;
  transport::ListenerOptions listener;
};

int send(const SendOptions& options) {
  Stream stream(options.uri, options.name, options.security);
  Description description;
  for (uint32_t i = 0; i < options.nodes; ++i)
    description.node_names.push_back("motion_" + std::to_string(i));
  description.nominal_rate_hz = options.rate_hz;
  stream.describe(description);
  std::vector<Pose> poses(options.nodes);
  const int64_t begun_ns = fire3dv::monotonic_ns();
  const auto step_ns = static_cast<int64_t>(1e9 / options.rate_hz);
  for (int64_t step = 0; !stop_requested; ++step) {
    const int64_t due_ns = begun_ns + step * step_ns;
    if (const int64_t left_ns = due_ns - fire3dv::monotonic_ns(); left_ns > 0)
      std::this_thread::sleep_for(std::chrono::nanoseconds(left_ns));
    // Real-time simulator: simulated time follows the clock, so that the true pose is known at any moment.
    const int64_t sim_ns = fire3dv::monotonic_ns() - begun_ns;
    if (options.seconds > 0 && static_cast<double>(sim_ns) > options.seconds * 1e9) break;
    for (Pose& pose : poses) pose = motion::known_pose(sim_ns).m;
    stream.publish(std::chrono::nanoseconds(sim_ns), poses);
    stream.poll();
  }
  return 0;
}

// Resident memory of this process in KiB; 0 when unknown.
uint64_t resident_kib() {
  std::ifstream statm("/proc/self/statm");
  uint64_t size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE)) / 1024;
}

nlohmann::json json_of(const motion::Score& score) {
  return {{"rms_mm", score.rms_mm},
          {"max_mm", score.max_mm},
          {"behind_ms", score.behind_ms},
          {"looks", score.looks}};
}

void say(const char* way, const motion::Score& score) {
  std::printf("%-12s %7.2f mm RMS, %7.2f mm most, %6.1f ms behind\n", way, score.rms_mm, score.max_mm,
              score.behind_ms);
}

int watch(const WatchOptions& options) {
  auto link = transport::open_listener(options.uri, options.listener);
  if (!link) {
    std::cerr << "fire3dv-motion: " << link.error().message << '\n';
    return 1;
  }
  std::cerr << "fire3dv-motion: listening on " << (*link)->uri() << '\n';
  constexpr size_t kMostRateHz = 1000;
  motion::Watcher watcher(static_cast<size_t>(options.seconds * kMostRateHz));
  const auto length_ns = static_cast<int64_t>(options.seconds * 1e9);
  int64_t end_ns = INT64_MAX, settled_ns = INT64_MAX;
  uint64_t settled_kib = 0;
  for (int64_t now_ns = 0; !stop_requested && now_ns < end_ns;) {
    (*link)->wait(std::chrono::milliseconds(10));
    now_ns = fire3dv::monotonic_ns();
    watcher.poll(**link, now_ns);
    if (end_ns == INT64_MAX && watcher.has_begun()) {
      end_ns = now_ns + length_ns;
      settled_ns = now_ns + length_ns / 4;
    }
    if (settled_kib == 0 && now_ns > settled_ns) settled_kib = resident_kib();
  }
  const uint64_t end_kib = resident_kib();
  const motion::Recording& recording = watcher.recording();
  if (!options.record.empty()) {
    std::ofstream file(options.record);
    if (!(file << motion::text_of(recording) << std::flush)) {
      std::cerr << "fire3dv-motion: --record " << options.record
                << " cannot be written; choose another file\n";
      return 1;
    }
  }
  const motion::Score latest = motion::score(recording, motion::Way::latest);
  const motion::Score interpolated = motion::score(recording, motion::Way::interpolated);
  const char* condition = state::condition_name(watcher.condition());
  if (options.as_json) {
    std::cout << nlohmann::json{{"frames", recording.size()},
                                {"missing", watcher.frames_missing()},
                                {"condition", condition},
                                {"times_late", watcher.times_late()},
                                {"times_lost", watcher.times_lost()},
                                {"settled_kib", settled_kib},
                                {"end_kib", end_kib},
                                {"latest", json_of(latest)},
                                {"interpolated", json_of(interpolated)}}
                     .dump()
              << '\n';
    return 0;
  }
  std::printf("%zu frames, %llu missing; %llu times late, %llu times lost, now %s\n", recording.size(),
              static_cast<unsigned long long>(watcher.frames_missing()),
              static_cast<unsigned long long>(watcher.times_late()),
              static_cast<unsigned long long>(watcher.times_lost()), condition);
  if (latest.looks == 0) {
    std::printf("too short for a score: look for more than 3 s while frames come\n");
    return 0;
  }
  say("latest", latest);
  say("interpolated", interpolated);
  return 0;
}

int score_file(const std::string& path) {
  std::ifstream file(path);
  const auto recording = motion::recording_of(file);
  if (!recording) {
    std::cerr << "fire3dv-motion: " << path
              << " is no recording; make one with fire3dv-motion watch --record\n";
    return 1;
  }
  say("latest", motion::score(*recording, motion::Way::latest));
  say("interpolated", motion::score(*recording, motion::Way::interpolated));
  return 0;
}

void add_send(CLI::App& app, SendOptions& options) {
  app.add_option("uri", options.uri, "where the watcher listens")->required();
  app.add_option("--rate", options.rate_hz, "frames a second")
      ->check(number_between(0.1, 1000))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "how long; 0: until told to stop")
      ->check(number_between(0, 1e6));
  app.add_option("--nodes", options.nodes, "bodies, all of which move alike")
      ->check(CLI::Range(1u, 100'000u))
      ->capture_default_str();
  app.add_option("--key-file", options.security.key_file, "file of the key for udp://");
  app.add_option("--tls-ca", options.security.tls_ca_file, "file of certificates to trust, for tls://");
}

void add_watch(CLI::App& app, WatchOptions& options) {
  app.add_option("uri", options.uri, "where to listen, as fire3dv --listen")->required();
  app.add_option("--seconds", options.seconds, "how long")
      ->check(number_between(0.1, 3600))
      ->capture_default_str();
  app.add_option("--record", options.record, "file for the times at which frames came");
  app.add_flag("--json", options.as_json, "one JSON object instead of text");
  add_listener_options(app, options.listener);
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app{
      "Says what a network makes of motion: how far from the truth it is seen, as it comes and interpolated.",
      "fire3dv-motion"};
  app.require_subcommand(1);
  SendOptions sending;
  WatchOptions watching;
  CLI::App* const sender = app.add_subcommand("send", "publish a known motion: a circle of 1 m at 1 m/s");
  add_send(*sender, sending);
  add_watch(*app.add_subcommand("watch", "stand where the renderer would, and score what comes"), watching);
  std::string recorded;
  CLI::App* const scorer = app.add_subcommand("score", "score what `watch --record` has written");
  scorer->add_option("file", recorded, "the recording")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageError;
  }
  std::signal(SIGINT, [](int) { stop_requested = 1; });
  std::signal(SIGTERM, [](int) { stop_requested = 1; });
  if (scorer->parsed()) return score_file(recorded);
  return sender->parsed() ? send(sending) : watch(watching);
} catch (const ClientError& error) {
  std::cerr << "fire3dv-motion: " << error.what() << '\n';
  return 1;
}
