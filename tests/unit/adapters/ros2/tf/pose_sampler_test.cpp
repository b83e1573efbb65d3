// Transform buffer and pose sampler: what ROS 2's tf2 has and ROS 1's has not, times, and the stated
// behaviours.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "adapters/ros2/tf/pose_sampler.h"

namespace fire3dv::ros2 {
namespace {

constexpr int64_t kMs = 1'000'000, kSecond = 1'000'000'000;

Transform at_x(double x) {
  return {{x, 0, 0}, {0, 0, 0, 1}};
}

struct World {
  explicit World(PoseSamplerOptions options = {}) : sampler(std::move(options)) {}

  Insertion moving(const char* parent, const char* child, int64_t stamp_ms, double x, SourceId source = 1) {
    return buffer.insert(parent, child, stamp_ms * kMs, at_x(x), false, source, now_ns);
  }
  Insertion fixed(const char* parent, const char* child, double x, SourceId source = 1) {
    return buffer.insert(parent, child, 0, at_x(x), true, source, now_ns);
  }
  std::optional<PoseSampler::Frame> after(int64_t ms) {
    now_ns += ms * kMs;
    return sampler.update(buffer, now_ns);
  }
  double x(const std::string& node) const {
    for (size_t i = 0; i < sampler.node_names().size(); ++i)
      if (sampler.node_names()[i] == node) return sampler.poses()[i][3];
    return std::nan("");
  }

  FrameBuffer buffer;
  PoseSampler sampler;
  int64_t now_ns = 1000 * kSecond;
};

TEST(Ros2Tf, StaticFrameMayBecomeMoving) {
  World world;
  world.fixed("a", "b", 1);
  EXPECT_TRUE(world.buffer.frames()[world.buffer.find("b")].is_static);
  EXPECT_EQ(world.moving("a", "b", 1000, 2), Insertion::accepted);
  EXPECT_TRUE(world.buffer.frames()[world.buffer.find("b")].is_stamped());
  world.fixed("a", "b", 3);
  EXPECT_EQ(world.buffer.frames()[world.buffer.find("b")].samples.size(), 1u);
}

TEST(Ros2Tf, NamesAndNumbersAreChecked) {
  World world;
  const std::string long_name(256, 'x');
  EXPECT_EQ(world.moving("a", long_name.c_str(), 1, 0), Insertion::bad_name);
  EXPECT_EQ(world.moving("a", "b\nc", 1, 0), Insertion::bad_name);
  EXPECT_EQ(world.moving("a", "\xff", 1, 0), Insertion::bad_name);
  EXPECT_EQ(world.moving("a", "b", 1, std::numeric_limits<double>::infinity()), Insertion::bad_number);
  EXPECT_EQ(world.moving("a", "b", 1, 1e300), Insertion::bad_number);
  EXPECT_TRUE(world.buffer.frames().empty());
  EXPECT_EQ(world.moving("a", "Tür", 1, 0), Insertion::accepted);
  // Extreme stamps: no overflow.
  for (const int64_t stamp : {std::numeric_limits<int64_t>::min(), std::numeric_limits<int64_t>::max()})
    world.buffer.insert("a", "e", stamp, at_x(0), false, 1, 1);
  world.after(300);
}

TEST(Ros2Tf, FramesAndSamplesAreBounded) {
  FrameBuffer buffer;
  for (int i = 0; i < 66000; ++i) buffer.insert("r", "f" + std::to_string(i), 1, at_x(0), false, 1, 1);
  EXPECT_EQ(buffer.frames().size(), FrameBuffer::kMaxFrames);
  EXPECT_EQ(buffer.insert("r", "new", 1, at_x(0), false, 1, 1), Insertion::too_many_frames);
  for (int i = 0; i < 30000; ++i) buffer.insert("r", "f0", 2 + i, at_x(0), false, 1, 1);
  EXPECT_LE(buffer.frames()[buffer.find("f0")].samples.size(), FrameBuffer::kMaxSamples);
}

TEST(Ros2Poses, ShareOldestOfNewestStamps) {
  World world;
  world.moving("map", "odom", 2000, 100);  // stamped ahead
  world.moving("map", "odom", 1000, 50);
  world.moving("odom", "base", 1000, 1);
  world.fixed("base", "laser", 0.5);
  EXPECT_FALSE(world.after(100));  // the set of frames may grow
  const auto first = world.after(200);
  ASSERT_TRUE(first);
  EXPECT_TRUE(first->is_new_layout);
  EXPECT_EQ(first->time_ns, 1000 * kMs);
  EXPECT_EQ(world.sampler.node_names(), (std::vector<std::string>{"odom", "base", "laser"}));
  EXPECT_FLOAT_EQ(world.x("odom"), 50);
  EXPECT_FALSE(world.after(1));  // nothing is newer
  world.moving("odom", "base", 1500, 2);
  const auto second = world.after(1);
  ASSERT_TRUE(second);
  EXPECT_FALSE(second->is_new_layout || second->is_discontinuity);
  EXPECT_EQ(second->time_ns, 1500 * kMs);
  EXPECT_FLOAT_EQ(world.x("odom"), 75);  // interpolated
  EXPECT_FLOAT_EQ(world.x("laser"), 77.5);
}

TEST(Ros2Poses, SilentFrameIsHeld) {
  World world;
  world.moving("map", "a", 1000, 1);
  world.moving("map", "b", 1000, 1);
  world.after(1);
  ASSERT_TRUE(world.after(300));
  world.moving("map", "b", 2000, 2);
  EXPECT_FALSE(world.after(10));  // waits for a
  for (int64_t t = 0; t < 10; ++t) {
    world.moving("map", "b", 2000 + 100 * (t + 1), 2 + 0.1 * static_cast<double>(t + 1));
    world.after(100);
  }
  EXPECT_FLOAT_EQ(world.x("b"), 3);
  EXPECT_FLOAT_EQ(world.x("a"), 1);
  world.moving("map", "a", 1100, 5);  // comes back late: time does not go back
  EXPECT_FALSE(world.after(1));
  world.moving("map", "a", 4000, 5);
  world.moving("map", "b", 4000, 5);
  EXPECT_EQ(world.after(1)->time_ns, 4000 * kMs);
}

TEST(Ros2Poses, GrowingSetWaitsForQuiet) {
  World world;
  int layouts = 0;
  for (int i = 0; i < 50; ++i) {
    world.moving("map", ("f" + std::to_string(i)).c_str(), 1000, i);
    const auto frame = world.after(100);
    layouts += frame && frame->is_new_layout;
  }
  EXPECT_GE(layouts, 2);
  EXPECT_LE(layouts, 3);
  world.after(300);
  EXPECT_EQ(world.sampler.node_names().size(), 50u);
  // A late static frame.
  world.fixed("f1", "late", 1);
  const auto early = world.after(20);
  EXPECT_FALSE(early && early->is_new_layout);
  const auto frame = world.after(300);
  ASSERT_TRUE(frame && frame->is_new_layout);
  EXPECT_FLOAT_EQ(world.x("late"), 2);
  // A static frame that changes.
  world.fixed("f1", "late", 3);
  ASSERT_TRUE(world.after(1));
  EXPECT_FLOAT_EQ(world.x("late"), 4);
  world.fixed("f1", "late", 3);
  EXPECT_FALSE(world.after(1));
}

TEST(Ros2Poses, TimeReversalDescribesAgain) {
  World world;
  for (int t = 0; t < 50; ++t) {
    world.moving("map", "a", 5000 + 10 * t, t);
    world.moving("map", "b", 5000 + 10 * t, t);
    world.after(10);
  }
  world.moving("map", "a", 1000, 7);  // one frame alone: ignored
  EXPECT_FALSE(world.buffer.frames()[world.buffer.find("a")].samples.size() > 100);
  world.moving("map", "a", 5600, 8);
  world.moving("map", "b", 5600, 8);
  EXPECT_FALSE(world.buffer.has_jumped_back(world.now_ns));
  world.after(10);
  for (const int64_t stamp_ms : {1000, 1001}) {
    EXPECT_FALSE(world.buffer.has_jumped_back(world.now_ns));
    world.moving("map", "a", stamp_ms, 7);
    world.moving("map", "b", stamp_ms, 7);
  }
  ASSERT_TRUE(world.buffer.has_jumped_back(world.now_ns));
  world.buffer.clear_moving();
  world.sampler.restart();
  world.moving("map", "a", 1010, 9);
  EXPECT_FALSE(world.after(30));  // not before all nodes are there again
  world.moving("map", "b", 1010, 9);
  const auto frame = world.after(30);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->is_new_layout && frame->is_discontinuity);
  EXPECT_EQ(frame->time_ns, 1010 * kMs);
  EXPECT_FLOAT_EQ(world.x("b"), 9);
}

TEST(Ros2Poses, OldSampleIsNoJump) {
  World world;
  world.moving("map", "a", 50'000, 1);
  world.moving("map", "a", 10'000, 2);
  world.moving("map", "a", 50'100, 1);
  world.moving("map", "a", 9'000, 2);
  world.moving("map", "a", 8'000, 2);
  EXPECT_FALSE(world.buffer.has_jumped_back(world.now_ns));
  world.moving("map", "a", 8'100, 2);
  EXPECT_TRUE(world.buffer.has_jumped_back(world.now_ns));
}

TEST(Ros2Poses, RestartIsJumpAfterSilence) {
  World world;
  world.moving("map", "a", 50'000, 1, 1);
  world.moving("map", "a", 10, 2, 2);
  world.moving("map", "a", 20, 2, 2);
  EXPECT_FALSE(world.buffer.has_jumped_back(world.now_ns));
  world.now_ns += 2 * kSecond;
  world.moving("map", "a", 2010, 2, 2);
  world.moving("map", "a", 2020, 2, 2);
  EXPECT_TRUE(world.buffer.has_jumped_back(world.now_ns));
}

TEST(Ros2Poses, DuplicatePublishersAreNamed) {
  World world;
  for (int i = 0; i < 4; ++i) {
    world.moving("map", "a", 1000 + i, 0, 1 + static_cast<SourceId>(i % 2));
    world.now_ns += 10 * kMs;
  }
  const std::vector<FrameConflict> conflicts = world.buffer.take_conflicts();
  ASSERT_FALSE(conflicts.empty());
  EXPECT_EQ(conflicts[0].first + conflicts[0].second, 3u);
  // A publisher that was restarted replaces the other one.
  World restarted;
  for (int i = 0; i < 8; ++i) {
    restarted.moving("map", "a", 1000 + i, 0, i < 4 ? 1 : 2);
    restarted.now_ns += 10 * kMs;
  }
  EXPECT_TRUE(restarted.buffer.take_conflicts().empty());
}

TEST(Ros2Poses, FaultsStayWithTheirFrames) {
  World world;
  world.moving("map", "good", 1000, 1);
  world.moving("b", "a", 1000, 1);
  world.moving("a", "b", 1000, 1);
  world.moving("b", "c", 1000, 1);
  world.moving("nowhere", "d", 1000, 1);
  world.after(1);
  ASSERT_TRUE(world.after(300));
  EXPECT_EQ(world.sampler.node_names(), std::vector<std::string>{"good"});
  size_t loops = 0, unconnected = 0;
  for (const FrameFault& fault : world.sampler.new_faults(world.buffer, true)) {
    loops += fault.kind == FrameFault::Kind::loop;
    unconnected += fault.kind == FrameFault::Kind::unconnected;
    if (fault.kind == FrameFault::Kind::unconnected) {
      EXPECT_EQ(world.buffer.frames()[fault.frame].name, "d");
      EXPECT_EQ(world.buffer.frames()[fault.other].name, "nowhere");
    }
  }
  EXPECT_EQ(loops, 3u);
  EXPECT_EQ(unconnected, 1u);
  EXPECT_TRUE(world.sampler.new_faults(world.buffer, true).empty());  // said once
  world.moving("map", "b", 1001, 1);                                  // the loop is opened
  world.after(30);
  ASSERT_TRUE(world.after(300));
  EXPECT_EQ(world.sampler.node_names().size(), 4u);
}

TEST(Ros2Poses, ClocksAreIndependent) {
  World world;
  int64_t time_ns = 0;
  for (int i = 0; i < 4; ++i) {
    world.moving("map", "sim1", 1000 + i, i);
    world.moving("map", "sim2", 995 + 5 * i, i);
    world.moving("map", "wall", 1'700'000'000'000 + i, i);
    if (const auto frame = world.after(150)) time_ns = frame->time_ns;
  }
  EXPECT_EQ(time_ns, 1003 * kMs);
  EXPECT_FLOAT_EQ(world.x("sim2"), 1.6f);
  EXPECT_FLOAT_EQ(world.x("wall"), 3);
  const std::vector<FrameFault> faults = world.sampler.new_faults(world.buffer, false);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].kind, FrameFault::Kind::other_clock);
  EXPECT_EQ(world.buffer.frames()[faults[0].frame].name, "wall");
}

TEST(Ros2Poses, FrameWithoutStampCountsAlways) {
  World world;
  world.moving("map", "a", 0, 1);
  world.moving("map", "b", 1000, 1);
  world.after(1);
  EXPECT_EQ(world.after(300)->time_ns, 1000 * kMs);
  world.moving("map", "a", 0, 4);
  ASSERT_TRUE(world.after(1));
  EXPECT_FLOAT_EQ(world.x("a"), 4);
  const std::vector<FrameFault> faults = world.sampler.new_faults(world.buffer, false);
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].kind, FrameFault::Kind::no_stamp);
}

TEST(Ros2Poses, FixedFrameAndPrefix) {
  World world({"odom", "r1/"});
  world.fixed("map", "odom", 100);
  world.moving("odom", "r1/base", 1000, 1);
  world.moving("odom", "r2/base", 1000, 2);
  world.fixed("map", "r1/flag", 3);
  world.after(1);
  ASSERT_TRUE(world.after(300));
  EXPECT_EQ(world.sampler.node_names(), (std::vector<std::string>{"base", "flag"}));
  EXPECT_FLOAT_EQ(world.x("base"), 1);
  EXPECT_FLOAT_EQ(world.x("flag"), -97);
  // Links only.
  world.sampler.set_links(std::vector<std::string>{"base", "missing"});
  world.after(1);
  ASSERT_TRUE(world.after(3000));
  EXPECT_EQ(world.sampler.node_names(), std::vector<std::string>{"base"});
}

TEST(Ros2Poses, DeepAndWideTrees) {
  World world;
  for (int i = 0; i < 2000; ++i)
    world.moving(("f" + std::to_string(i)).c_str(), ("f" + std::to_string(i + 1)).c_str(), 1000, 1);
  world.after(1);
  ASSERT_TRUE(world.after(300));
  EXPECT_EQ(world.sampler.node_names().size(), 2000u);
  EXPECT_FLOAT_EQ(world.x("f2000"), 2000);
}

}  // namespace
}  // namespace fire3dv::ros2
