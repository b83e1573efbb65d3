// Motion smoothness program fire3dv-motion: `send` publishes the reference motion, `watch` listens like a
// renderer and reports the displayed error, `score` evaluates a recorded run again.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "base/clock.h"
#include "base/command_line.h"
#include "fire3dv/client.hpp"
#include "programs/listener_options.h"
#include "protocol/transport/link.h"
#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/pose_state.h"
#include "tools/lab/motion/score.h"

namespace fire3dv::motion {
namespace {

// Listener that records arrival times of the reference motion's frames.
class Watcher {
 public:
  // Allocates the whole recording immediately, so that later memory growth is not the recording's.
  explicit Watcher(size_t max_frames);

  // Processes pending messages and updates the stream's condition.
  void poll(transport::ListenerLink& link, int64_t now_ns);

  bool has_begun() const { return !recording_.empty(); }
  const Recording& recording() const { return recording_; }
  uint64_t frames_missing() const { return frames_missing_; }  // skipped sequences
  // Transitions to late and lost, and the current condition.
  uint64_t times_late() const { return times_late_; }
  uint64_t times_lost() const { return times_lost_; }
  state::Condition condition() const { return condition_; }

 private:
  void take(transport::PeerId peer, std::span<const std::byte> message, int64_t received_ns);
  void note_condition();

  size_t max_frames_;
  scene::Scene scene_;
  state::PoseState poses_{scene_};
  state::StreamId stream_ = state::kNone;
  transport::PeerId peer_ = 0;
  uint64_t epoch_ = 0;
  wire::Decoder decoder_;
  Recording recording_;
  uint64_t frames_missing_ = 0;
  state::Condition condition_ = state::Condition::live;
  uint64_t times_late_ = 0, times_lost_ = 0;
};

using transport::LinkEvent;

Watcher::Watcher(size_t max_frames) : max_frames_(max_frames) {
  recording_.assign(max_frames, {});  // touches the pages, so that they are resident
  recording_.clear();
}

void Watcher::poll(transport::ListenerLink& link, int64_t now_ns) {
  link.poll([&](const LinkEvent& event) {
    if (event.kind == LinkEvent::Kind::note)
      std::fprintf(stderr, "fire3dv-motion: %s\n", std::string(event.text).c_str());
    if (event.kind == LinkEvent::Kind::pose || event.kind == LinkEvent::Kind::control)
      take(event.peer, event.message, event.received_ns != 0 ? event.received_ns : now_ns);
    if (stream_ != state::kNone && event.peer == peer_) link.accept(peer_);
  });
  if (stream_ == state::kNone) return;
  (void)poses_.advance(now_ns);
  note_condition();
}

void Watcher::note_condition() {
  using state::Condition;
  const Condition was = std::exchange(condition_, poses_.streams()[stream_].condition);
  if (was == condition_) return;
  std::fprintf(stderr, "fire3dv-motion: %s\n", state::condition_name(condition_));
  times_lost_ += condition_ == Condition::lost;
  times_late_ += was == Condition::live;
}

void Watcher::take(transport::PeerId peer, std::span<const std::byte> message, int64_t received_ns) {
  const auto decoded = decoder_.decode(message);
  if (!decoded) return;
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    if (stream_ != state::kNone && description->epoch != epoch_) return;  // only the first stream is watched
    peer_ = peer;
    if (stream_ != state::kNone) return;
    stream_ = poses_.add_stream(*description);
    epoch_ = description->epoch;
    return;
  }
  if (stream_ == state::kNone || peer != peer_) return;
  const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded);
  if (frame == nullptr || !poses_.push(stream_, *frame, received_ns, received_ns)) return;
  const wire::PoseFrameHeader& whole = poses_.streams()[stream_].header;
  if (!has_begun()) std::fprintf(stderr, "fire3dv-motion: frames come\n");
  if (has_begun()) frames_missing_ += whole.sequence - recording_.back().sequence - 1;
  if (recording_.size() < max_frames_)
    recording_.push_back({whole.sequence, whole.sim_time_ns, whole.publish_time_ns, received_ns});
}

}  // namespace
}  // namespace fire3dv::motion

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
    for (Pose& pose : poses) pose = motion::reference_pose(sim_ns).m;
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
          {"looks", score.samples}};
}

void print_score(const char* way, const motion::Score& score) {
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
  constexpr size_t kMaxRateHz = 1000;
  motion::Watcher watcher(static_cast<size_t>(options.seconds * kMaxRateHz));
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
  if (latest.samples == 0) {
    std::printf("too short for a score: watch frames for more than 3 s\n");
    return 0;
  }
  print_score("latest", latest);
  print_score("interpolated", interpolated);
  return 0;
}

int score_file(const std::string& path) {
  std::ifstream file(path);
  const auto recording = motion::recording_of(file);
  if (!recording) {
    std::cerr << "fire3dv-motion: " << path
              << " is not a recording; make one with fire3dv-motion watch --record\n";
    return 1;
  }
  print_score("latest", motion::score(*recording, motion::Way::latest));
  print_score("interpolated", motion::score(*recording, motion::Way::interpolated));
  return 0;
}

void add_send(CLI::App& app, SendOptions& options) {
  app.add_option("uri", options.uri, "URI of the watcher: udp, tcp or tls://HOST:PORT, or shm://NAME")
      ->required();
  OptionGroup group(app), security(app, "Security");
  group.add("--rate", options.rate_hz, "HZ", "frames per second")->check(number_between(0.1, 1000));
  group.add("--seconds", options.seconds, "S", "duration; 0: until interrupted")
      ->check(number_between(0, 1e6));
  group.add("--nodes", options.nodes, "N", "bodies, all with the same motion")->check(in_range(1u, 100'000u));
  security.add("--key-file", options.security.key_file, "FILE", "udp: pre-shared key, 64 hexadecimal digits");
  security.add("--tls-ca", options.security.tls_ca_file, "FILE", "tls: trusted certificates (PEM)");
}

void add_watch(CLI::App& app, WatchOptions& options) {
  app.add_option("uri", options.uri, "URI to listen at, as fire3dv --listen")->required();
  OptionGroup group(app);
  group.add("--seconds", options.seconds, "S", "duration from the first frame")
      ->check(number_between(0.1, 3600));
  group.add("--record", options.record, "FILE", "write the arrival times of frames");
  group.add_flag("--json", options.as_json, "print one JSON object");
  add_listener_options(app, options.listener);
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app{"Measures the motion error that a network causes, with the newest frame and interpolated.",
               "fire3dv-motion"};
  set_help(app, "COMMAND [OPTIONS]");
  set_program_flags(app);
  app.footer("Options of a command: fire3dv-motion COMMAND --help. Details: man fire3dv-motion.");
  app.require_subcommand(1);
  const auto add_command = [&](const char* name, const char* text, const char* usage) {
    CLI::App* const command = app.add_subcommand(name, text);
    set_help(*command, usage);
    return command;
  };
  SendOptions sending;
  WatchOptions watching;
  CLI::App* const sender =
      add_command("send", "publish a reference motion: a circle of 1 m at 1 m/s", "URI [OPTIONS]");
  add_send(*sender, sending);
  add_watch(*add_command("watch", "receive the motion and print its error", "URI [OPTIONS]"), watching);
  std::string recorded;
  CLI::App* const scorer = add_command("score", "print the error from a file of watch --record", "FILE");
  scorer->add_option("file", recorded, "file of watch --record")->required();
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
