// Test of interpolation quality over simulated networks, seeded and in simulated time. With jitter as the
// main disturbance the error of interpolated motion is at most a third of the newest frame's error.
#include "tools/lab/motion/score.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "tools/lab/impair/impairment.h"

namespace fire3dv::motion {
namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kSecond = 1000 * kMs;
constexpr int64_t kClocksApart = 77 * kSecond;

struct Network {
  const char* name;
  impair::Impairment impairment;
  double rate_hz = 60;
  int64_t down_from_ns = 0, down_until_ns = 0;
};

impair::Impairment with(double loss, double delay_ms, double jitter_ms, double reorder = 0,
                        double duplicate = 0, uint64_t bits_per_second = 0) {
  impair::Impairment impairment;
  impairment.loss = loss;
  impairment.delay_ns = static_cast<int64_t>(delay_ms * 1e6);
  impairment.jitter_ns = static_cast<int64_t>(jitter_ms * 1e6);
  impairment.reorder = reorder;
  impairment.duplicate = duplicate;
  impairment.bits_per_second = bits_per_second;
  impairment.seed = 42;
  return impairment;
}

// Simulates a listener of single-datagram frames: duplicates and superseded frames are dropped.
Recording over(const Network& network, int64_t length_ns = 40 * kSecond) {
  constexpr size_t kDatagramBytes = 260;
  impair::DatagramChannel channel(network.impairment.seed);
  Recording recording;
  const auto step_ns = static_cast<int64_t>(1e9 / network.rate_hz);
  uint64_t sequence = 0;
  for (int64_t now_ns = 0; now_ns < length_ns; now_ns += step_ns) {
    impair::Impairment impairment = network.impairment;
    impairment.down = now_ns >= network.down_from_ns && now_ns < network.down_until_ns;
    const auto fate = channel.draw(impairment, kDatagramBytes, now_ns);
    ++sequence;
    for (int copy = 0; copy < fate.copies; ++copy)
      recording.push_back({sequence, now_ns, static_cast<uint64_t>(now_ns + kClocksApart), fate.due_ns});
  }
  std::stable_sort(recording.begin(), recording.end(),
                   [](const Arrival& a, const Arrival& b) { return a.received_ns < b.received_ns; });
  uint64_t newest = 0;
  std::erase_if(recording, [&](const Arrival& arrival) {
    if (arrival.sequence <= newest) return true;
    newest = arrival.sequence;
    return false;
  });
  return recording;
}

TEST(MotionScore, GoodNetworkIsExact) {
  const Recording recording = over({"good", with(0, 5, 0)});
  const Score interpolated = score(recording, Way::interpolated);
  EXPECT_LT(interpolated.rms_mm, 0.05);
  EXPECT_LT(interpolated.max_mm, 0.3);
  EXPECT_LT(score(recording, Way::latest).rms_mm, 6) << "a frame is shown until the next comes: 17 ms";
  EXPECT_GT(interpolated.samples, 2000u);
}

TEST(MotionScore, ConstantDelayIsNoError) {
  const Score near = score(over({"near", with(0, 5, 0)}), Way::interpolated);
  const Score far = score(over({"far", with(0, 300, 0)}), Way::interpolated);
  EXPECT_NEAR(near.rms_mm, far.rms_mm, 0.01);
  EXPECT_NEAR(near.behind_ms, far.behind_ms, 0.1) << "the way itself is not counted";
}

TEST(MotionScore, JitterDropsByTwoThirds) {
  const Network networks[] = {
      {"20 ms of jitter", with(0, 50, 20)},
      {"1 % lost", with(0.01, 50, 20)},
      {"5 % lost", with(0.05, 50, 20)},
      {"20 % lost", with(0.20, 50, 20)},
      {"a quarter overtakes", with(0, 50, 20, 0.25)},
      {"a tenth comes twice", with(0, 50, 20, 0, 0.1)},
      {"1 Mbit/s", with(0, 50, 20, 0, 0, 1'000'000)},
      {"250 Hz", with(0.05, 50, 20), 250},
      {"20 Hz", with(0.01, 50, 20), 20},
      {"5 s without a link", with(0.01, 50, 20), 60, 15 * kSecond, 20 * kSecond},
  };
  for (const Network& network : networks) {
    const Recording recording = over(network);
    const Score interpolated = score(recording, Way::interpolated);
    const Score latest = score(recording, Way::latest);
    std::printf("%-20s interpolated %5.2f mm RMS, %6.2f most, %5.1f ms behind; latest %5.2f, %6.2f, %5.1f\n",
                network.name, interpolated.rms_mm, interpolated.max_mm, interpolated.behind_ms, latest.rms_mm,
                latest.max_mm, latest.behind_ms);
    EXPECT_LE(interpolated.rms_mm, latest.rms_mm / 3) << network.name;
    EXPECT_LE(interpolated.max_mm, latest.max_mm) << network.name;
    EXPECT_EQ(interpolated.samples, latest.samples);
  }
}

TEST(MotionScore, RecordingRoundTrips) {
  const Recording recording = over({"jitter", with(0.05, 50, 20)}, 5 * kSecond);
  std::istringstream text(text_of(recording));
  const auto again = recording_of(text);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->size(), recording.size());
  EXPECT_EQ(score(*again, Way::interpolated).rms_mm, score(recording, Way::interpolated).rms_mm);
  for (const char* bad : {"", "1 2 3", "1 2 3 x", "2 0 0 5\n1 0 0 6\n", "1 0 0 6\n2 0 0 5\n", "1 0 0 -5\n"}) {
    std::istringstream wrong(bad);
    EXPECT_FALSE(recording_of(wrong)) << bad;
  }
}

TEST(MotionScore, NothingIsNothing) {
  EXPECT_EQ(score({}, Way::latest).samples, 0u);
  EXPECT_EQ(score({}, Way::interpolated).rms_mm, 0);
}

}  // namespace
}  // namespace fire3dv::motion
