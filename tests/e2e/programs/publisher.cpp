// Scripted simulator of the end-to-end tests: publishes on command from standard input, and answers each line
// with one status line. The nodes move along x, so that their position in an image identifies the sequence.
//
//   publisher URI ADAPTER_NAME [--millimetres] NODE...
//
// --millimetres: the stream is Z up, in millimetres, about another origin; the images are the same.
//
// Lines:
// - publish N: N frames in a row, without polling the link between them
// - lockstep N: N frames, each after a renderer has shown the one before
// - stream HZ: frames at this rate until the next line
// - hide NODE: a scene edit
// - status: no action except for the answer
// - rest: describe the nodes again with a new epoch
// - quit: end the stream with a goodbye, as does the end of the input
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "fire3dv/client.hpp"

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// Must equal the constants of tests/e2e/support/harness.py; one unit is one pixel there.
constexpr uint64_t kPlaces = 32;
constexpr float kFirstPlace = -70, kPlaceStep = 4;
constexpr auto kSimStep = 10ms;
constexpr auto kHangLimit = 300s;

float place_of(uint64_t sequence) {
  return kFirstPlace + kPlaceStep * static_cast<float>(sequence % kPlaces);
}

constexpr float kUnitsPerMetre = 1000, kOriginX = 12;  // of --millimetres

class Simulator {
 public:
  Simulator(const std::string& uri, const std::string& name, bool millimetres, std::vector<std::string> nodes)
      : stream_(uri, name), millimetres_(millimetres), nodes_(std::move(nodes)) {
    describe();
  }

  void describe() {
    fire3dv::Description description;
    description.node_names = nodes_;
    if (millimetres_) {
      description.world_from_stream = {0.001, 0, 0, kOriginX, 0, 0, 0.001, 0, 0, -0.001, 0, 0};
      description.body_from_node = {
          {kUnitsPerMetre, 0, 0, 0, 0, 0, -kUnitsPerMetre, 0, 0, kUnitsPerMetre, 0, 0}};
    }
    stream_.describe(description);
    sequence_ = 0;
  }
  void hide(const std::string& node) { stream_.set_visible(node, false); }
  void publish() {
    ++sequence_;
    const float place = place_of(sequence_);
    const float x = millimetres_ ? (place - kOriginX) * kUnitsPerMetre : place;
    const std::vector<fire3dv::Pose> poses(nodes_.size(), {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0});
    stream_.publish(sequence_ * kSimStep, poses);
    published_++;
  }
  bool lockstep(uint64_t frames) {
    for (uint64_t i = 0; i < frames; ++i) {
      publish();
      if (!stream_.wait_ack(sequence_, kHangLimit)) return false;
    }
    return true;
  }
  void poll() { stream_.poll(); }
  void answer(const char* word) {
    const fire3dv_status status = stream_.poll();
    std::printf(
        "%s calls=%llu published=%llu sequence=%llu acked=%llu dropped=%llu renderers=%u welcome=%d "
        "unmatched=%u conflicting=%u contested=%u "
        "epoch=%016llx message=%s\n",
        word, static_cast<unsigned long long>(published_),
        static_cast<unsigned long long>(status.frames_published),
        static_cast<unsigned long long>(status.sequence),
        static_cast<unsigned long long>(status.acked_sequence),
        static_cast<unsigned long long>(status.frames_dropped), status.renderers, status.welcome,
        status.unmatched_names, status.conflicting_names, status.contested_names,
        static_cast<unsigned long long>(status.epoch), status.welcome_message);
    std::fflush(stdout);
  }

 private:
  fire3dv::Stream stream_;
  bool millimetres_;
  std::vector<std::string> nodes_;
  uint64_t sequence_ = 0;
  uint64_t published_ = 0;
};

class Lines {
 public:
  // Returns false at the end of the input. An empty line means that none came within the time-out.
  bool next(std::string& line, Clock::duration timeout) {
    line.clear();
    for (;;) {
      const size_t end = text_.find('\n');
      if (end != std::string::npos) {
        line = text_.substr(0, end);
        text_.erase(0, end + 1);
        return true;
      }
      pollfd input{STDIN_FILENO, POLLIN, 0};
      const auto wait = std::chrono::duration_cast<std::chrono::milliseconds>(timeout).count();
      if (::poll(&input, 1, static_cast<int>(wait > 0 ? wait : 0)) == 0) return true;
      char buffer[256];
      const ssize_t got = ::read(STDIN_FILENO, buffer, sizeof buffer);
      if (got <= 0) return false;
      text_.append(buffer, static_cast<size_t>(got));
    }
  }

 private:
  std::string text_;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 4) {
    std::fprintf(stderr, "usage: publisher URI ADAPTER_NAME [--millimetres] NODE...\n");
    return 2;
  }
  const bool millimetres = std::string(argv[3]) == "--millimetres";
  Simulator simulator(argv[1], argv[2], millimetres, {argv + (millimetres ? 4 : 3), argv + argc});
  Lines lines;
  std::string line;
  double rate_hz = 0;
  Clock::time_point next_frame = Clock::now();
  while (lines.next(line, rate_hz > 0 ? next_frame - Clock::now() : Clock::duration(5ms))) {
    simulator.poll();
    if (line.empty()) {
      if (rate_hz > 0 && Clock::now() >= next_frame) {
        simulator.publish();
        next_frame = Clock::now() +
                     std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / rate_hz));
      }
      continue;
    }
    const size_t blank = line.find(' ');
    const std::string word = line.substr(0, blank);
    const std::string value = blank == std::string::npos ? "0" : line.substr(blank + 1);
    rate_hz = 0;
    bool good = true;
    if (word == "publish") {
      for (uint64_t i = std::strtoull(value.c_str(), nullptr, 10); i > 0; --i) simulator.publish();
    } else if (word == "lockstep") {
      good = simulator.lockstep(std::strtoull(value.c_str(), nullptr, 10));
    } else if (word == "stream") {
      rate_hz = std::atof(value.c_str());
      next_frame = Clock::now();
    } else if (word == "hide") {
      simulator.hide(value);
    } else if (word == "rest") {
      simulator.describe();
    } else if (word == "quit") {
      simulator.answer("ok");
      return 0;
    } else if (word != "status") {
      good = false;
    }
    simulator.answer(good ? "ok" : "failed");
  }
  return 0;
} catch (const fire3dv::ClientError& error) {
  std::fprintf(stderr, "publisher: %s\n", error.what());
  return 1;
}
