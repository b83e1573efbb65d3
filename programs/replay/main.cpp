// Replay program: fire3dv-replay FILE.mcap --to URI publishes a recording again, with its original timing.
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/command_line.h"
#include "base/log.h"
#include "base/process/failure.h"
#include "base/process/stop_signals.h"
#include "base/text.h"
#include "protocol/record/playback.h"
#include "protocol/replay/replay_clock.h"
#include "protocol/replay/stream_player.h"
#include "protocol/transport/open.h"
#include "protocol/wire/check.h"

namespace {

using namespace fire3dv;

constexpr int kUsageError = 2;
constexpr int64_t kPollEveryNs = 5 * fire3dv::kMillisecondNs;

struct Options {
  std::string file;
  std::vector<std::string> to, streams;
  double speed = 1, start_s = 0, end_s = 0;
  bool loop = false, step = false, wait = false, verbatim = false;
  uint64_t memory_mb = 64;
  transport::PublisherOptions publisher;
};

int fail(const std::string& message) {
  fire3dv::print_log_line("fire3dv-replay", fire3dv::error_line(message));
  return 1;
}

class Replay {
 public:
  Replay(record::Playback playback, const Options& options)
      : playback_(std::move(playback)), options_(options), pacer_(options.speed) {}

  Result<void> open_links();
  Result<void> run();
  void print_result() const;

 private:
  Result<bool> run_once(bool again);
  // Waits and processes renderers' messages meanwhile. Returns false on a stop signal.
  bool wait(int64_t ns);
  void wait_for_renderers();
  // Waits for a line on standard input. Returns false at its end and on a stop signal.
  bool wait_for_line();

  record::Playback playback_;
  const Options& options_;
  replay::Pacer pacer_;
  std::vector<std::unique_ptr<replay::StreamPlayer>> players_;  // by stream; null: not selected
  uint64_t damaged_ = 0;
  size_t lines_ = 0;  // lines read but not consumed
  bool begun_line_ = false;
};

Result<void> Replay::open_links() {
  const auto& streams = playback_.streams();
  std::vector<size_t> chosen;
  std::string names;
  for (size_t i = 0; i < streams.size(); ++i) {
    names += (i ? ", \"" : "\"") + wire::printable(streams[i].name) + "\"";
    if (options_.streams.empty()) chosen.push_back(i);
  }
  // In order of the options: each --to belongs to the --stream at the same position.
  for (const std::string& name : options_.streams) {
    const auto found = std::ranges::find(streams, name, &record::Playback::Stream::name);
    if (found == streams.end())
      return Error{"--stream \"" + wire::printable(name) + "\" is not in the recording; it has " + names};
    chosen.push_back(static_cast<size_t>(found - streams.begin()));
  }
  if (options_.to.size() != 1 && options_.to.size() != chosen.size())
    return Error{"--to is given " + std::to_string(options_.to.size()) + " times for " +
                 std::to_string(chosen.size()) + " streams (" + names +
                 "); give it once, or once for each stream"};
  if (options_.to.size() == 1 && chosen.size() > 1 && options_.to[0].starts_with("shm:"))
    return Error{"one shared-memory name takes one stream; choose one of " + names +
                 " with --stream, or give --to once for each"};
  players_.resize(streams.size());
  for (size_t i = 0; i < chosen.size(); ++i) {
    auto link = transport::open_publisher(options_.to[options_.to.size() == 1 ? 0 : i], options_.publisher);
    if (!link) return link.error();
    players_[chosen[i]] = std::make_unique<replay::StreamPlayer>(std::move(*link), options_.verbatim);
  }
  return {};
}

bool Replay::wait(int64_t ns) {
  const int64_t until_ns = fire3dv::monotonic_ns() + ns;
  for (;;) {
    for (const auto& player : players_)
      if (player) player->poll();
    const int64_t left_ns = until_ns - fire3dv::monotonic_ns();
    if (stop_requested) return false;
    if (left_ns <= 0) return true;
    std::this_thread::sleep_for(std::chrono::nanoseconds(std::min(left_ns, kPollEveryNs)));
  }
}

void Replay::wait_for_renderers() {
  for (bool all = false; !all && wait(kPollEveryNs);) {
    all = true;
    for (const auto& player : players_)
      if (player) all = player->poll() != 0 && all;
  }
}

// Polls in short intervals, so that renderers are served and signals end the wait.
bool Replay::wait_for_line() {
  while (wait(0)) {
    if (lines_ != 0) {
      --lines_;
      return true;
    }
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (::poll(&input, 1, static_cast<int>(kPollEveryNs / fire3dv::kMillisecondNs)) <= 0) continue;
    char text[4096];
    const ssize_t bytes = ::read(STDIN_FILENO, text, sizeof text);
    if (bytes < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (bytes <= 0) return std::exchange(begun_line_, false);  // the last line may lack a line end
    lines_ += static_cast<size_t>(std::count(text, text + bytes, '\n'));
    begun_line_ = text[bytes - 1] != '\n';
  }
  return false;
}

// Returns false when there is nothing to play.
Result<bool> Replay::run_once(bool again) {
  const uint64_t begin_ns = playback_.start_ns() + static_cast<uint64_t>(options_.start_s * 1e9);
  const uint64_t end_ns =
      options_.end_s > 0 ? playback_.start_ns() + static_cast<uint64_t>(options_.end_s * 1e9) : UINT64_MAX;
  options_.start_s > 0 ? playback_.seek(begin_ns) : playback_.rewind();
  if (again || options_.start_s > 0)
    for (const auto& player : players_)
      if (player) player->jump(again);
  pacer_.restart();
  bool any = false;
  record::Played played;
  while (!stop_requested) {
    const record::Playback::Step step = playback_.next(played);
    if (step == record::Playback::Step::end) break;
    if (step == record::Playback::Step::damaged) {
      if (damaged_++ == 0) print_log_line("fire3dv-replay", warning(playback_.problem()));
      continue;
    }
    if (played.log_time_ns > end_ns) break;
    replay::StreamPlayer* const player = players_[played.stream].get();
    if (player == nullptr) continue;
    const bool is_pose = played.kind == record::Played::Kind::pose;
    if (options_.step) {
      if (is_pose && !wait_for_line()) break;
      player->poll();
    } else {
      const int64_t wait_ns = pacer_.wait_ns(played.log_time_ns, fire3dv::monotonic_ns());
      if (wait_ns > replay::kLongWaitNs)
        print_log_line("fire3dv-replay",
                       "info: " + replay::long_wait_text(wait_ns, played.log_time_ns - playback_.start_ns()));
      if (!wait(wait_ns)) break;
    }
    if (auto good = player->play(played); !good) return good.error();
    any = any || is_pose;
    // The link sends the description once a renderer is connected; the following messages must find it
    // connected.
    if (options_.wait && !again && played.kind == record::Played::Kind::description) {
      wait_for_renderers();
      pacer_.restart();
    }
  }
  return any;
}

Result<void> Replay::run() {
  for (bool again = false;; again = true) {
    const auto any = run_once(again);
    if (!any) return any.error();
    if (!options_.loop || !*any || stop_requested || !wait(fire3dv::kMillisecondNs)) break;
  }
  for (const auto& player : players_)
    if (player) player->end();
  return {};
}

void Replay::print_result() const {
  for (size_t i = 0; i < players_.size(); ++i) {
    if (!players_[i]) continue;
    const replay::PlayerCounts& counts = players_[i]->counts();
    std::printf(
        "\"%s\": %llu frames, %llu messages passed over, %llu frames incomplete\n",
        wire::printable(playback_.streams()[i].name).c_str(), static_cast<unsigned long long>(counts.frames),
        static_cast<unsigned long long>(counts.skipped), static_cast<unsigned long long>(counts.incomplete));
    if (counts.dropped_edits != 0)
      std::printf("%llu edits left out: too many to store\n",
                  static_cast<unsigned long long>(counts.dropped_edits));
    if (const std::string problem = players_[i]->problem(); !problem.empty())
      std::printf("%s\n", fire3dv::terminal_text(problem).c_str());
  }
  if (damaged_ + playback_.refused() != 0)
    std::printf("%llu chunks damaged, %llu messages not understood\n",
                static_cast<unsigned long long>(damaged_),
                static_cast<unsigned long long>(playback_.refused()));
}

int replay_file(const Options& options) {
  auto source = record::open_source(options.file);
  if (!source) return fail(source.error().message);
  auto playback = record::Playback::open(std::move(*source), {options.memory_mb << 20});
  if (!playback) return fail(playback.error().message);
  if (!playback->reader().index().damage.empty())
    std::fprintf(stderr, "fire3dv-replay: info: %s: %s\n", wire::printable(options.file, 4096).c_str(),
                 playback->reader().index().damage.c_str());
  Replay replay(std::move(*playback), options);
  if (auto good = replay.open_links(); !good) return fail(good.error().message);
  if (auto good = replay.run(); !good) return fail(good.error().message);
  replay.print_result();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Publishes the streams of a recording with their recorded timing.", "fire3dv-replay"};
  set_help(app, "FILE.mcap --to URI [OPTIONS]");
  app.footer("Details: man fire3dv-replay.");
  set_program_flags(app);
  Options options;
  app.add_option("file", options.file, "recording (.mcap)")->required();
  OptionGroup group(app);
  group.add("--to", options.to, "URI", "shm://NAME, or tcp, tls, udp://HOST:PORT; once, or once a stream")
      ->required();
  group.add("--stream", options.streams, "NAME", "play these streams only, in the order of --to");
  group.add("--speed", options.speed, "X", "factor on the recorded speed; 0: unpaced")->check(check_number);
  group.add_flag("--loop", options.loop, "repeat, each time as a new run of the stream");
  group.add("--start", options.start_s, "SECONDS", "begin SECONDS into the recording")->check(check_number);
  group.add("--end", options.end_s, "SECONDS", "end SECONDS into the recording; 0: at its end")
      ->check(check_number);
  group.add_flag("--step", options.step, "publish one frame for each line of standard input");
  group.add_flag("--wait", options.wait, "begin when a renderer has connected");
  group.add_flag("--verbatim", options.verbatim, "keep recorded publish times and clocks");
  group.add("--memory-mb", options.memory_mb, "N", "memory for the index of the file, in MB")
      ->check(in_range(16u, 16'384u));
  add_client_security(app, options.publisher.key_file, options.publisher.tls.ca_file,
                      options.publisher.tls.certificate_file, options.publisher.tls.key_file);
  try {
    app.parse(argc, argv);
    if (std::set(options.streams.begin(), options.streams.end()).size() != options.streams.size())
      throw CLI::ValidationError("--stream", "a stream is named twice; name each once");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageError;
  }
  install_stop_signals(SecondStop::ignored);
  try {
    return replay_file(options);
  } catch (const std::exception& failure) {
    print_log_line("fire3dv-replay", error_line(describe_failure(failure)));
    return 1;
  }
}
