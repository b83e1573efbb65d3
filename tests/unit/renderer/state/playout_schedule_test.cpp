// Test of frame scheduling in simulator time, fitted to the local clock, and of the late and lost conditions.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "renderer/state/playout.h"
#include "renderer/state/stream_timing.h"

namespace fire3dv::state {
namespace {

constexpr int64_t kScheduleMs = 1'000'000;
constexpr int64_t kScheduleSecond = 1000 * kScheduleMs;

// Simulator with regular steps and irregular publish times.
struct Source {
  double ns_per_sim_ns = 1;
  int64_t step_ns = 10 * kScheduleMs;
  int64_t sim_ns = 500 * kScheduleSecond, clock_ns = 40 * kScheduleSecond;

  PlayoutSchedule::Slot next(PlayoutSchedule& schedule, int64_t unevenness_ns = 0) {
    sim_ns += step_ns;
    clock_ns += static_cast<int64_t>(ns_per_sim_ns * static_cast<double>(step_ns));
    return schedule.next(sim_ns, clock_ns + unevenness_ns, false);
  }
};

TEST(PlayoutSchedule, UnevenPublishingIsSmooth) {
  PlayoutSchedule schedule;
  Source source;
  std::mt19937 generator(5);
  std::uniform_int_distribution<int64_t> jitter(0, 8 * kScheduleMs);
  int64_t before = 0;
  double worst = 0;
  for (int i = 0; i < 600; ++i) {
    const PlayoutSchedule::Slot slot = source.next(schedule, jitter(generator));
    if (i > 100)
      worst = std::max(worst, std::abs(static_cast<double>(slot.due_ns - before - 10 * kScheduleMs)));
    if (i > 0) {
      EXPECT_EQ(slot.from_ns, before);
    }
    before = slot.due_ns;
  }
  EXPECT_LT(worst, 1.5 * kScheduleMs) << "of steps of 10 ms that were published with 8 ms of unevenness";
}

TEST(PlayoutSchedule, BurstsAreSpreadOut) {
  PlayoutSchedule schedule;
  Source source;
  int64_t before = 0;
  for (int i = 0; i < 800; ++i) {
    const int64_t wait = 10 * kScheduleMs * (3 - i % 4);  // four at once, when the last of them is done
    const PlayoutSchedule::Slot slot = source.next(schedule, wait);
    if (i > 200) {
      EXPECT_NEAR(static_cast<double>(slot.due_ns - before), 10.0 * kScheduleMs, 4.0 * kScheduleMs) << i;
    }
    before = slot.due_ns;
  }
}

TEST(PlayoutSchedule, OtherRatesAreFollowed) {
  for (const double pace : {0.02, 0.5, 1.0, 4.0, 300.0}) {  // clock seconds per simulated second
    PlayoutSchedule schedule;
    Source source;
    source.ns_per_sim_ns = pace;
    PlayoutSchedule::Slot slot;
    for (int i = 0; i < 300; ++i) slot = source.next(schedule);
    EXPECT_NEAR(static_cast<double>(slot.due_ns), static_cast<double>(source.clock_ns), 0.1 * kScheduleMs)
        << pace;
    EXPECT_NEAR(static_cast<double>(slot.due_ns - slot.from_ns), pace * 10 * kScheduleMs,
                0.01 * pace * 10 * kScheduleMs);
  }
}

TEST(PlayoutSchedule, ChangeOfPaceIsFollowed) {
  PlayoutSchedule schedule;
  Source source;
  for (int i = 0; i < 300; ++i) (void)source.next(schedule);
  for (const double pace : {2.0, 0.25, 60.0, 1.0}) {
    source.ns_per_sim_ns = pace;
    PlayoutSchedule::Slot slot;
    for (int i = 0; i < 400; ++i) {
      slot = source.next(schedule);
      EXPECT_LE(std::abs(slot.due_ns - source.clock_ns), 50 * kScheduleMs) << pace << " " << i;
      EXPECT_LE(slot.from_ns, slot.due_ns);
    }
    EXPECT_NEAR(static_cast<double>(slot.due_ns), static_cast<double>(source.clock_ns), 5.0 * kScheduleMs)
        << pace;
  }
}

TEST(PlayoutSchedule, PauseEndsOnTime) {
  PlayoutSchedule schedule;
  Source source;
  PlayoutSchedule::Slot before;
  for (int i = 0; i < 300; ++i) before = source.next(schedule);
  source.clock_ns += 20 * kScheduleSecond;
  const PlayoutSchedule::Slot slot = source.next(schedule);
  EXPECT_EQ(slot.due_ns, source.clock_ns);
  EXPECT_NEAR(static_cast<double>(slot.due_ns - slot.from_ns), 10.0 * kScheduleMs, 0.1 * kScheduleMs)
      << "and not 20 s for one step";
  const PlayoutSchedule::Slot after = source.next(schedule);
  EXPECT_NEAR(static_cast<double>(after.due_ns - after.from_ns), 10.0 * kScheduleMs, 0.1 * kScheduleMs)
      << "as before";
}

TEST(PlayoutSchedule, StoppedSimulatorUsesClock) {
  PlayoutSchedule schedule;
  Source source;
  for (int i = 0; i < 100; ++i) (void)source.next(schedule);
  for (int i = 0; i < 100; ++i) {
    source.clock_ns += 10 * kScheduleMs;
    const PlayoutSchedule::Slot slot = schedule.next(source.sim_ns, source.clock_ns, false);
    EXPECT_NEAR(static_cast<double>(slot.due_ns), static_cast<double>(source.clock_ns), 0.1 * kScheduleMs);
  }
  const PlayoutSchedule::Slot slot = source.next(schedule);
  EXPECT_NEAR(static_cast<double>(slot.due_ns), static_cast<double>(source.clock_ns), 0.1 * kScheduleMs);
}

TEST(PlayoutSchedule, IntoAJumpNothingMoves) {
  PlayoutSchedule schedule;
  Source source;
  for (int i = 0; i < 100; ++i) (void)source.next(schedule);
  source.sim_ns = 0;  // restarts without a discontinuity flag
  PlayoutSchedule::Slot slot = source.next(schedule);
  EXPECT_EQ(slot.from_ns, slot.due_ns);
  slot = source.next(schedule);
  EXPECT_NEAR(static_cast<double>(slot.due_ns - slot.from_ns), 10.0 * kScheduleMs, 0.1 * kScheduleMs);
  slot = schedule.next(source.sim_ns += 10 * kScheduleMs, source.clock_ns += 10 * kScheduleMs, true);
  EXPECT_EQ(slot.from_ns, slot.due_ns) << "nor where the simulator says that bodies jump";
}

TEST(PlayoutSchedule, WildTimesDoNoHarm) {
  PlayoutSchedule schedule;
  std::mt19937_64 generator(8);
  int64_t due = INT64_MIN;
  for (int i = 0; i < 20'000; ++i) {
    const int64_t clock = int64_t{i} * kScheduleMs;
    const auto sim = generator() % 3 ? static_cast<int64_t>(generator()) : int64_t{i};
    const PlayoutSchedule::Slot slot = schedule.next(sim, clock, generator() % 7 == 0);
    EXPECT_GE(slot.due_ns, due) << "frames stay in order";
    EXPECT_LE(slot.from_ns, slot.due_ns);
    EXPECT_LE(std::abs(slot.due_ns - clock), 300 * kScheduleMs);
    due = slot.due_ns;
  }
}

// End to end: a body at speed 1 in simulated time, published in bursts by a simulator at half real time.
TEST(Playout, MovesInSimulatedTime) {
  Playout playout(100 * kScheduleMs);
  wire::PoseFrameHeader header;
  header.epoch = 1;
  double last_x = 0, least = 1e9, most = 0;
  for (int64_t now = 0; now < 6 * kScheduleSecond; now += 5 * kScheduleMs) {
    if (now % (80 * kScheduleMs) == 0) {
      for (int i = 0; i < 4; ++i) {
        ++header.sequence;
        header.sim_time_ns += 10 * kScheduleMs;
        wire::Affine3x4 pose;
        pose.m = {1, 0, 0, static_cast<float>(static_cast<double>(header.sim_time_ns) * 1e-9), 0, 1, 0, 0, 0,
                  0, 1, 0};
        playout.add(header, {&pose, 1}, now, now);
      }
    }
    const auto shown = playout.at(now);
    if (!shown) continue;
    const double x = static_cast<double>(shown->poses[0].m[3]);
    if (now > 3 * kScheduleSecond) {
      least = std::min(least, (x - last_x) / 0.005);
      most = std::max(most, (x - last_x) / 0.005);
    }
    last_x = x;
    EXPECT_NEAR(static_cast<double>(shown->header.sim_time_ns) * 1e-9, x, 1e-6);
  }
  EXPECT_GT(least, 0.25) << "it never stops";
  EXPECT_LT(most, 0.8) << "nor hurries";
}

TEST(Playout, RisingDelayNeverGoesBack) {
  Playout playout;
  std::mt19937 generator(4);
  wire::PoseFrameHeader header;
  double last_x = -1;
  for (int64_t now = 0; now < 4 * kScheduleSecond; now += 10 * kScheduleMs) {
    wire::Affine3x4 pose;
    pose.m[3] = static_cast<float>(now / kScheduleMs);
    ++header.sequence;
    header.sim_time_ns = now;
    // After two seconds the network latency rises abruptly.
    playout.add(header, {&pose, 1}, now - (now > 2 * kScheduleSecond ? 150 * kScheduleMs : 5 * kScheduleMs),
                now);
    const auto shown = playout.at(now);
    ASSERT_TRUE(shown);
    EXPECT_GE(static_cast<double>(shown->poses[0].m[3]), last_x - 21) << "beyond what was carried on";
    last_x = static_cast<double>(shown->poses[0].m[3]);
  }
}

TEST(Liveness, SilenceIsLateAndThenLost) {
  Liveness stream;
  EXPECT_EQ(stream.at(100 * kScheduleSecond), Condition::live) << "nothing is held that never came";
  int64_t now = kScheduleSecond;
  for (int i = 0; i < 100; ++i) stream.on_frame(now += 16 * kScheduleMs);
  EXPECT_EQ(stream.at(now + 200 * kScheduleMs), Condition::live);
  EXPECT_EQ(stream.at(now + 300 * kScheduleMs), Condition::late);
  EXPECT_EQ(stream.at(now + 3100 * kScheduleMs), Condition::lost);
  stream.on_frame(now += 10 * kScheduleSecond);
  EXPECT_EQ(stream.at(now), Condition::live);
  stream.on_frame(now += 16 * kScheduleMs);
  EXPECT_EQ(stream.at(now + 300 * kScheduleMs), Condition::late) << "one pause does not make a slow stream";
}

TEST(Liveness, SlowStreamIsNotLate) {
  Liveness stream;
  int64_t now = kScheduleSecond;
  for (int i = 0; i < 20; ++i) stream.on_frame(now += 800 * kScheduleMs);
  EXPECT_EQ(stream.at(now + 1000 * kScheduleMs), Condition::live);
  EXPECT_EQ(stream.at(now + 4000 * kScheduleMs), Condition::late);
  EXPECT_EQ(stream.at(now + 8 * kScheduleSecond), Condition::lost);
}

}  // namespace
}  // namespace fire3dv::state
