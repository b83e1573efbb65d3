// Test of stream playout from another machine: clock offset, pose interpolation, playout delay against
// jitter, jumps, pauses.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "renderer/state/playout.h"
#include "renderer/state/pose_state.h"
#include "renderer/state/stream_timing.h"

namespace fire3dv::state {
namespace {

constexpr int64_t kMs = 1'000'000;
constexpr int64_t kSecond = 1000 * kMs;

wire::Affine3x4 turned(double angle_rad, double scale = 1, float x = 0) {
  wire::Affine3x4 pose;
  pose.m = {static_cast<float>(scale * std::cos(angle_rad)),
            static_cast<float>(-std::sin(angle_rad)),
            0,
            x,
            static_cast<float>(scale * std::sin(angle_rad)),
            static_cast<float>(std::cos(angle_rad)),
            0,
            0,
            0,
            0,
            1,
            0};
  return pose;
}

void expect_near(const wire::Affine3x4& a, const wire::Affine3x4& b, float most = 1e-5f) {
  for (size_t i = 0; i < 12; ++i) EXPECT_NEAR(a.m[i], b.m[i], most) << i;
}

TEST(Interpolate, TransformsInterpolateEvenly) {
  const wire::Affine3x4 a = turned(0.2, 1, 1), b = turned(1.8, 3, 5);
  EXPECT_EQ(interpolate(a, b, 0), a);
  EXPECT_EQ(interpolate(a, b, 1), b);
  expect_near(interpolate(a, b, 0.25), turned(0.6, 1.5, 2));
  expect_near(interpolate(a, b, 1.5), turned(2.6, 4, 7));
  expect_near(interpolate(turned(-3.0), turned(3.0), 0.5), turned(std::numbers::pi), 1e-4f);
}

TEST(Interpolate, MirrorsStayMirrors) {
  wire::Affine3x4 a = turned(0.2, -2), b = turned(1.0, -4);
  expect_near(interpolate(a, b, 0.5), turned(0.6, -3));
}

TEST(Interpolate, NonRigidInterpolatesByElement) {
  wire::Affine3x4 sheared = turned(0), flat = turned(0), mirrored = turned(0, -1);
  sheared.m[1] = 1;
  flat.m[0] = 0;
  for (const wire::Affine3x4& other : {sheared, flat, mirrored}) {
    const wire::Affine3x4 a = turned(1.0, 2, 3), middle = interpolate(a, other, 0.5);
    for (size_t i = 0; i < 12; ++i) EXPECT_NEAR(middle.m[i], (a.m[i] + other.m[i]) / 2, 1e-6f) << i;
  }
}

TEST(ClockOffset, PingsBoundTheError) {
  ClockOffset clock;
  EXPECT_EQ(clock.source(), ClockOffset::Source::none);
  const int64_t offset = 123 * kSecond + 456;
  std::mt19937 generator(1);
  std::exponential_distribution<double> queue(1.0 / (20 * kMs));
  for (int i = 0; i < 100; ++i) {
    const int64_t sent = i * kSecond;
    const auto out = 5 * kMs + static_cast<int64_t>(queue(generator)),
               back = 5 * kMs + static_cast<int64_t>(queue(generator));
    clock.on_pong(sent, static_cast<uint64_t>(sent + out - offset + 200 * kSecond), sent + out + back);
    const int64_t error =
        clock.local_ns(static_cast<uint64_t>(1000 * kSecond)) - (1000 * kSecond + offset - 200 * kSecond);
    EXPECT_LE(std::abs(error), clock.uncertainty_ns());
  }
  EXPECT_EQ(clock.source(), ClockOffset::Source::round_trip);
  EXPECT_LE(clock.uncertainty_ns(), 12 * kMs) << "the least disturbed of the last ones counts";
}

TEST(ClockOffset, FastestFrameBoundsOffset) {
  ClockOffset clock;
  std::mt19937 generator(2);
  std::uniform_int_distribution<int64_t> way(10 * kMs, 60 * kMs);
  for (int i = 0; i < 600; ++i)
    clock.on_frame(static_cast<uint64_t>(i * 16 * kMs), 77 * kSecond + i * 16 * kMs + way(generator));
  EXPECT_EQ(clock.source(), ClockOffset::Source::one_way);
  EXPECT_EQ(clock.soonest_ns(5), clock.local_ns(5));
  const int64_t error = clock.local_ns(0) - 77 * kSecond;
  EXPECT_GE(error, 10 * kMs);
  EXPECT_LE(error, 12 * kMs);
  const int64_t soonest = clock.soonest_ns(5);
  clock.on_pong(900 * kSecond, static_cast<uint64_t>(823 * kSecond), 900 * kSecond + 4 * kMs);
  EXPECT_EQ(clock.source(), ClockOffset::Source::round_trip);
  EXPECT_EQ(clock.soonest_ns(5), soonest) << "pings tell where the clocks are, and move no picture";
  clock.same_clock();
  EXPECT_EQ(clock.local_ns(5), 5);
  EXPECT_EQ(clock.soonest_ns(5), 5);
}

TEST(ClockOffset, LongerDelayIsFollowedSlowly) {
  ClockOffset clock;
  int64_t before = 0;
  for (int64_t i = 1; i < 6000; ++i) {  // one minute, then two with 100 ms more latency
    const int64_t way = i < 2000 ? 10 * kMs : 110 * kMs;
    clock.on_frame(static_cast<uint64_t>(i * 30 * kMs), i * 30 * kMs + way);
    const int64_t offset = clock.soonest_ns(0);
    if (i > 1) {
      EXPECT_LE(std::abs(offset - before), 30 * kMs / 400) << i;
    }
    before = offset;
  }
  EXPECT_EQ(before, 110 * kMs);
  clock.on_frame(static_cast<uint64_t>(6000 * 30 * kMs), 6000 * 30 * kMs + 20 * kMs);
  EXPECT_EQ(clock.soonest_ns(0), 20 * kMs);
  // A jump of a clock is not latency.
  for (int64_t i = 6001; i < 7000; ++i)
    clock.on_frame(static_cast<uint64_t>(i * 30 * kMs), i * 30 * kMs + 50 * kSecond);
  EXPECT_EQ(clock.soonest_ns(0), 50 * kSecond);
}

// Wild times of the publisher's clock spoil an estimate only until their samples expire.
TEST(ClockOffset, WildTimesExpire) {
  ClockOffset by_frames, by_pongs;
  by_pongs.on_pong(2, 5, 1);  // an answer that comes before its question
  EXPECT_EQ(by_pongs.source(), ClockOffset::Source::none);
  int64_t now_ns = kSecond;
  for (const uint64_t wild : {uint64_t{0}, UINT64_MAX, uint64_t{1} << 63}) {
    by_frames.on_frame(wild, now_ns);
    by_pongs.on_pong(now_ns - 4 * kMs, wild, now_ns);
  }
  EXPECT_NE(by_frames.local_ns(78 * kSecond), kSecond);
  EXPECT_NE(by_pongs.local_ns(78 * kSecond), kSecond);
  for (int i = 0; i < 20; ++i) {  // the publisher's clock is 77 s ahead
    now_ns += kSecond;
    const auto published_ns = static_cast<uint64_t>(now_ns + 77 * kSecond);
    by_frames.on_frame(published_ns, now_ns + 10 * kMs);
    by_pongs.on_pong(now_ns - 3 * kMs, published_ns, now_ns + 3 * kMs);
  }
  EXPECT_EQ(by_frames.local_ns(78 * kSecond), kSecond + 10 * kMs);
  EXPECT_EQ(by_frames.soonest_ns(78 * kSecond), kSecond + 10 * kMs);
  EXPECT_EQ(by_pongs.local_ns(78 * kSecond), kSecond);
  EXPECT_EQ(by_pongs.uncertainty_ns(), 3 * kMs);
}

class PlayoutTest : public testing::Test {
 protected:
  // A body on a circle, so that position and rotation both matter.
  static wire::Affine3x4 truth(int64_t t_ns) {
    const double angle = 2 * static_cast<double>(t_ns) * 1e-9;
    wire::Affine3x4 pose = turned(angle);
    pose.m[3] = static_cast<float>(std::cos(angle));
    pose.m[7] = static_cast<float>(std::sin(angle));
    return pose;
  }
  bool add(Playout& playout, uint64_t sequence, int64_t published_ns, int64_t received_ns,
           uint32_t flags = 0) {
    wire::PoseFrameHeader header;
    header.epoch = 1;
    header.sequence = sequence;
    header.sim_time_ns = published_ns;
    header.flags = flags;
    const wire::Affine3x4 pose = truth(published_ns);
    return playout.add(header, {&pose, 1}, published_ns, received_ns);
  }
  static double distance(const wire::Affine3x4& a, const wire::Affine3x4& b) {
    return std::hypot(static_cast<double>(a.m[3] - b.m[3]), static_cast<double>(a.m[7] - b.m[7]));
  }
};

// Error of the shown motion at its stated time, and its smoothness, compared with showing the latest frame.
TEST_F(PlayoutTest, InterpolationUndoesJitter) {
  struct Arrival {
    int64_t at_ns, published_ns;
    uint64_t sequence;
  };
  std::mt19937 generator(3);
  std::uniform_int_distribution<int64_t> jitter(-20 * kMs, 20 * kMs);
  std::vector<Arrival> arrivals;
  for (int64_t i = 0; i < 1200; ++i)
    arrivals.push_back(
        {i * 16 * kMs + 50 * kMs + jitter(generator), i * 16 * kMs, static_cast<uint64_t>(i + 1)});
  std::sort(arrivals.begin(), arrivals.end(),
            [](const Arrival& a, const Arrival& b) { return a.at_ns < b.at_ns; });

  Playout playout;
  size_t next = 0;
  uint64_t newest = 0;
  int64_t newest_published = 0;
  double squares_interpolated = 0, squares_latest = 0;
  int samples = 0;
  for (int64_t now = 0; now < 18 * kSecond; now += 16'666'667) {
    for (; next < arrivals.size() && arrivals[next].at_ns <= now; ++next) {
      add(playout, arrivals[next].sequence, arrivals[next].published_ns, arrivals[next].at_ns);
      if (arrivals[next].sequence <= newest) continue;
      newest = arrivals[next].sequence;
      newest_published = arrivals[next].published_ns;
    }
    const auto shown = playout.at(now);
    if (now < 3 * kSecond) continue;  // the delay settles
    ASSERT_TRUE(shown);
    squares_interpolated += std::pow(distance(shown->poses[0], truth(now - playout.delay_ns())), 2);
    squares_latest +=
        std::pow(distance(truth(newest_published), truth(now - 50 * kMs)), 2);  // without its mean delay
    ++samples;
  }
  const double interpolated = std::sqrt(squares_interpolated / samples),
               latest = std::sqrt(squares_latest / samples);
  RecordProperty("rms_interpolated", std::to_string(interpolated));
  RecordProperty("rms_latest", std::to_string(latest));
  EXPECT_LT(interpolated, latest / 3) << latest;
  EXPECT_LE(playout.delay_ns(), 110 * kMs);
  EXPECT_GE(playout.delay_ns(), 60 * kMs);
}

TEST_F(PlayoutTest, AFixedDelayIsKept) {
  Playout playout(40 * kMs);
  for (int64_t i = 0; i < 20; ++i)
    add(playout, static_cast<uint64_t>(i + 1), i * 10 * kMs, i * 10 * kMs + 5 * kMs);
  EXPECT_EQ(playout.delay_ns(), 40 * kMs);
  const auto shown = playout.at(145 * kMs);
  ASSERT_TRUE(shown);
  expect_near(shown->poses[0], truth(105 * kMs), 1e-3f);
  EXPECT_EQ(shown->header.sim_time_ns, 105 * kMs);
  EXPECT_EQ(shown->header.sequence, 11u);
}

TEST_F(PlayoutTest, MotionContinuesBriefly) {
  Playout playout(0);
  for (int64_t i = 0; i < 5; ++i) add(playout, static_cast<uint64_t>(i + 1), i * 10 * kMs, i * 10 * kMs);
  expect_near(playout.at(50 * kMs)->poses[0], truth(50 * kMs), 1e-3f);
  expect_near(playout.at(60 * kMs)->poses[0], truth(60 * kMs), 3e-3f);
  EXPECT_GT(distance(playout.at(61 * kMs)->poses[0], truth(61 * kMs)), 1e-3) << "bounded by two intervals";
  const auto held = playout.at(200 * kMs);
  EXPECT_EQ(held->poses[0], truth(40 * kMs)) << "where the simulator stands";
  EXPECT_EQ(held->header.sequence, 5u);
  EXPECT_FALSE(playout.at(300 * kMs)->changed);
}

TEST_F(PlayoutTest, NothingIsInterpolatedIntoJump) {
  Playout playout(0);
  add(playout, 1, 0, 0);
  add(playout, 2, 10 * kMs, 10 * kMs);
  add(playout, 3, 20 * kMs, 20 * kMs, wire::kFrameDiscontinuity);
  EXPECT_EQ(playout.at(19 * kMs)->poses[0], truth(10 * kMs));
  EXPECT_EQ(playout.at(20 * kMs)->poses[0], truth(20 * kMs));
  EXPECT_EQ(playout.at(29 * kMs)->poses[0], truth(20 * kMs)) << "nor beyond it";
}

TEST_F(PlayoutTest, LateFramesAreOrdered) {
  Playout playout(30 * kMs);
  EXPECT_FALSE(playout.at(0));
  EXPECT_TRUE(add(playout, 1, 0, 0));
  EXPECT_TRUE(add(playout, 3, 20 * kMs, 20 * kMs));
  EXPECT_FALSE(add(playout, 3, 20 * kMs, 21 * kMs));
  EXPECT_TRUE(add(playout, 2, 10 * kMs, 25 * kMs));
  expect_near(playout.at(45 * kMs)->poses[0], truth(15 * kMs), 1e-3f);
  EXPECT_TRUE(add(playout, 4, 30 * kMs, 46 * kMs));
  (void)playout.at(60 * kMs);
  EXPECT_FALSE(add(playout, 1, 0, 61 * kMs)) << "passed by";
}

// The same through the pose state that the renderer draws.
TEST_F(PlayoutTest, MotionFollowsTime) {
  scene::Scene scene;
  PoseState state(scene);
  wire::StreamDescription description;
  description.epoch = 7;
  description.node_names = {"a"};
  const StreamId id = state.add_stream(description);
  state.interpolate(id, 20 * kMs);
  const auto push = [&](uint64_t sequence, int64_t at_ns) {
    const wire::Affine3x4 pose = truth(at_ns);
    wire::PoseFrameView frame;
    frame.header.epoch = 7;
    frame.header.sequence = sequence;
    frame.node_count = 1;
    frame.poses = {&pose, 1};
    return state.push(id, frame, at_ns, at_ns + kMs);
  };
  EXPECT_FALSE(state.advance(1)) << "nothing is there";
  for (int i = 1; i <= 5; ++i)
    EXPECT_FALSE(push(static_cast<uint64_t>(i), i * 10 * kMs)) << "its time has not come";
  EXPECT_TRUE(state.advance(55 * kMs));
  expect_near(state.streams()[id].poses[0], truth(35 * kMs), 1e-3f);
  EXPECT_EQ(state.streams()[id].header.sequence, 3u);
  EXPECT_FALSE(state.advance(55 * kMs)) << "the same moment";
  EXPECT_TRUE(state.advance(57 * kMs));
  EXPECT_EQ(state.streams()[id].frames_received, 5u);
  EXPECT_EQ(state.streams()[id].condition, Condition::live);
  (void)state.advance(kSecond);
  EXPECT_EQ(state.streams()[id].condition, Condition::late);
  EXPECT_EQ(state.streams()[id].poses[0], truth(50 * kMs));
}

TEST_F(PlayoutTest, MemoryIsBounded) {
  Playout playout;
  std::mt19937_64 generator(9);
  for (uint64_t i = 1; i < 20'000; ++i) {
    wire::PoseFrameHeader header;
    header.sequence = i;
    header.sim_time_ns = static_cast<int64_t>(generator());
    const wire::Affine3x4 pose;
    const auto published = static_cast<int64_t>(generator());
    playout.add(header, {&pose, 1}, published, static_cast<int64_t>(i) * kMs);
    (void)playout.at(static_cast<int64_t>(i) * kMs);
    EXPECT_LE(playout.delay_ns(), 1000 * kMs);
  }
}

// Changes the playout of a running stream: no frame is lost or incomplete.
TEST_F(PlayoutTest, SwitchLosesNoFrame) {
  scene::Scene scene;
  for (const char* const name : {"top", "box0", "box1"}) {
    scene::Node& node = scene.nodes.emplace_back();
    node.name = node.path = name;
  }
  PoseState poses(scene);
  wire::StreamDescription description;
  description.adapter_name = "arm";
  description.epoch = 7;
  description.node_names = {"box0", "box1"};
  const StreamId id = poses.add_stream(description);
  const auto push = [&](uint64_t sequence, std::vector<float> x, std::vector<uint32_t> nodes = {}) {
    std::vector<wire::Affine3x4> frame(x.size());
    for (size_t i = 0; i < x.size(); ++i) frame[i].m[3] = x[i];
    wire::PoseFrameView view;
    view.header.epoch = 7;
    view.header.sequence = sequence;
    const auto at = static_cast<int64_t>(sequence) * 10 * kMs;
    view.header.sim_time_ns = at;
    view.node_count = 2;
    view.poses = frame;
    view.node_indices = nodes;
    return poses.push(id, view, at, at);
  };
  const auto x = [&](uint32_t node) { return poses.world_from_node(node)[3].x; };
  EXPECT_TRUE(push(1, {1, 10}));
  EXPECT_EQ(x(1), 1);

  poses.interpolate(id, 20 * kMs);
  EXPECT_FALSE(push(2, {2}, {0}));  // a partial frame directly afterwards
  EXPECT_EQ(x(1), 1);               // not due yet
  poses.advance(40 * kMs);
  EXPECT_EQ(x(1), 2);
  EXPECT_EQ(x(2), 10);

  push(3, {3, 30});
  poses.interpolate(id, 500 * kMs);  // another delay
  push(4, {4}, {0});
  poses.show_newest(id, 45 * kMs);  // pending frames are shown immediately
  EXPECT_EQ(x(1), 4);
  EXPECT_EQ(x(2), 30);
  EXPECT_TRUE(push(5, {5}, {0}));
  EXPECT_EQ(x(1), 5);
  EXPECT_EQ(x(2), 30);
}

}  // namespace
}  // namespace fire3dv::state
