// Crash test of the shared-memory writer: a thousand simulators in turn publish on one name and are killed at
// random moments. The polling reader never stops, accepts no torn frame, and follows each next simulator.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <random>

#include "base/clock.h"
#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"
#include "tests/e2e/programs/self_identifying_frames.h"
#include "tests/unit/protocol/transport/child.h"

namespace fire3dv::test {
namespace {

using fire3dv::monotonic_ns;

constexpr uint64_t kRuns = 1000;
constexpr size_t kNodes = 100;
constexpr int64_t kHangNs = int64_t{60} * 1'000'000'000;

// Reader of the current stream; checks each message and reports faults as test failures.
class Follower {
 public:
  explicit Follower(const std::string& uri) {
    auto opened = transport::open_listener(uri);
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    if (opened.ok()) link_ = std::move(*opened);
  }

  void poll() {
    link_->wait(std::chrono::microseconds(200));
    link_->poll([&](const transport::LinkEvent& event) {
      using Kind = transport::LinkEvent::Kind;
      if (event.kind == Kind::note) ADD_FAILURE() << event.text;
      if (event.kind == Kind::control || event.kind == Kind::pose) take(event.message);
    });
  }

  uint64_t run() const { return run_; }
  uint64_t frames_of_run() const { return frames_of_run_; }
  uint64_t frames() const { return frames_; }
  // Time from the first publish of this run to the receipt of its first frame here.
  int64_t followed_after_ns() const { return followed_after_ns_; }

 private:
  void take(std::span<const std::byte> bytes) {
    const auto message = decoder_.decode(bytes);
    ASSERT_TRUE(message.ok()) << message.error().message;
    if (const auto* description = std::get_if<wire::StreamDescription>(&*message)) {
      ASSERT_EQ(description->adapter_name.rfind("run ", 0), 0u);
      const uint64_t run = std::stoull(description->adapter_name.substr(4));
      EXPECT_GT(run + 1, next_run_) << "a dead simulator is back";
      next_run_ = run + 1;
      run_ = run;
      epoch_ = description->epoch;
      sequence_ = frames_of_run_ = 0;
    } else if (const auto* frame = std::get_if<wire::PoseFrameView>(&*message)) {
      EXPECT_EQ(frame->header.epoch, epoch_);
      EXPECT_GT(frame->header.sequence, sequence_) << "an older frame came after a newer one";
      EXPECT_EQ(frame->poses.size(), kNodes);
      EXPECT_TRUE(tells(run_, frame->header.sequence, 0, frame->poses))
          << "frame " << frame->header.sequence << " of run " << run_ << " holds something else";
      sequence_ = frame->header.sequence;
      // sim_time_ns holds the time of the simulator's first publish.
      if (frames_of_run_ == 0) followed_after_ns_ = monotonic_ns() - frame->header.sim_time_ns;
      ++frames_of_run_;
      ++frames_;
    }
  }

  std::unique_ptr<transport::ListenerLink> link_;
  wire::Decoder decoder_;
  uint64_t run_ = 0, next_run_ = 0, epoch_ = 0, sequence_ = 0, frames_of_run_ = 0, frames_ = 0;
  int64_t followed_after_ns_ = 0;
};

void simulate(const std::string& uri, uint64_t run, uint32_t pause_us) {
  SelfIdentifyingPublisher simulator(uri, run, kNodes);
  if (!simulator.good()) ::_exit(1);
  const int64_t first_ns = monotonic_ns();
  while (simulator.publish(first_ns))
    if (pause_us != 0) ::usleep(pause_us);
  ::_exit(1);
}

double milliseconds_at(const std::vector<int64_t>& sorted_ns, double fraction) {
  return static_cast<double>(
             sorted_ns[static_cast<size_t>(fraction * static_cast<double>(sorted_ns.size() - 1))]) /
         1e6;
}

TEST(KilledWriters, KilledWritersLeaveWholeFrames) {
  const std::string uri = "shm://test-killed-writers-" + std::to_string(::getpid());
  Follower follower(uri);
  std::mt19937 generator(20261);
  std::vector<int64_t> followed_ns;
  uint64_t killed_unseen = 0;
  for (uint64_t run = 0; run < kRuns; ++run) {
    // Some simulators publish without a pause, so that most kills hit a frame half written; others pause.
    const uint32_t pause_us = generator() % 4 == 0 ? 500 : 0;
    const int64_t alive_ns = static_cast<int64_t>(generator() % 3'000'000);
    // One of four is killed early, by the clock: while it opens or describes, or before the reader sees it.
    // The others are killed alive_ns after the reader follows them.
    const bool by_clock = generator() % 4 == 0 && run + 1 < kRuns;
    transport::test::Child simulator([&] { simulate(uri, run, pause_us); });
    const int64_t started_ns = monotonic_ns();
    std::optional<int64_t> seen_ns;
    const auto is_over = [&] {
      if (by_clock) return monotonic_ns() - started_ns >= alive_ns;
      return seen_ns && monotonic_ns() - *seen_ns >= alive_ns;
    };
    while (!is_over()) {
      follower.poll();
      if (!seen_ns && follower.run() == run && follower.frames_of_run() > 0) {
        seen_ns = monotonic_ns();
        followed_ns.push_back(follower.followed_after_ns());
      }
      ASSERT_LT(monotonic_ns() - started_ns, kHangNs) << "run " << run << " is not followed";
      ASSERT_FALSE(HasFailure()) << "run " << run;
    }
    killed_unseen += !seen_ns;
    simulator.kill();
  }
  EXPECT_GE(followed_ns.size(), kRuns / 2);
  EXPECT_EQ(followed_ns.size() + killed_unseen, kRuns);
  EXPECT_GE(follower.frames(), followed_ns.size());
  EXPECT_TRUE(transport::open_publisher(uri).ok());  // its end removes the segment of the last simulator
  std::sort(followed_ns.begin(), followed_ns.end());
  std::printf(
      "| killed | followed | frames accepted | torn | followed after, median | p99 | most |\n"
      "|---|---|---|---|---|---|---|\n"
      "| %llu | %zu | %llu | 0 | %.2f ms | %.2f ms | %.2f ms |\n",
      static_cast<unsigned long long>(kRuns), followed_ns.size(),
      static_cast<unsigned long long>(follower.frames()), milliseconds_at(followed_ns, 0.5),
      milliseconds_at(followed_ns, 0.99), milliseconds_at(followed_ns, 1));
}

}  // namespace
}  // namespace fire3dv::test
