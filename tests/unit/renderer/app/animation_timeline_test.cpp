// Test of the timeline of animations: pause, steps, seeks, loops and the simulated time of a stream.
#include <gtest/gtest.h>

#include "renderer/app/loop/animation_timeline.h"

namespace fire3dv::app {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

struct Timeline {
  int64_t now_ns = 5 * kSecond;
  AnimationTimeline timeline{2.0, [this] { return now_ns; }};
  double at() { return timeline.at({}); }
};

TEST(AnimationTimeline, PlaysUntilItIsPaused) {
  Timeline t;
  t.now_ns += kSecond / 2;
  EXPECT_NEAR(t.at(), 0.5, 1e-9);
  t.timeline.pause();
  t.now_ns += kSecond;
  EXPECT_NEAR(t.at(), 0.5, 1e-9);
  EXPECT_FALSE(t.timeline.timeline().playing);
  t.timeline.play();
  t.now_ns += kSecond;
  EXPECT_NEAR(t.at(), 1.5, 1e-9);
  t.timeline.set_speed(2);
  t.now_ns += kSecond;
  EXPECT_NEAR(t.at(), 3.5, 1e-9) << "animations repeat themselves";
  EXPECT_EQ(t.timeline.timeline().position_ns, uint64_t{3 * kSecond / 2});
  t.timeline.set_speed(0);
  EXPECT_EQ(t.timeline.timeline().speed, 1);
}

TEST(AnimationTimeline, StepsWrapAroundInLoop) {
  Timeline t;
  t.timeline.step();
  EXPECT_NEAR(t.at(), 1.0 / 30, 1e-6);
  t.now_ns += kSecond;
  t.timeline.step_back();
  t.timeline.step_back();
  EXPECT_NEAR(t.at(), 2 - 1.0 / 30, 1e-6);
  EXPECT_FALSE(t.timeline.timeline().playing);
  t.timeline.set_looping(false);
  for (int i = 0; i < 3; ++i) t.timeline.step();
  EXPECT_TRUE(t.timeline.timeline().at_end);
  EXPECT_LT(t.at(), 2) << "at its last key an animation begins again";
  EXPECT_GT(t.at(), 1.999);
  t.timeline.play();
  EXPECT_NEAR(t.at(), 0, 1e-9);
}

TEST(AnimationTimeline, SeeksStayWithinTheAnimations) {
  Timeline t;
  t.timeline.seek(uint64_t{1} << 63);
  EXPECT_EQ(t.timeline.timeline().end_ns, uint64_t{2 * kSecond});
  EXPECT_NEAR(t.at(), 2, 1e-9);
  AnimationTimeline empty(0);
  empty.step();
  empty.step_back();
  EXPECT_EQ(empty.timeline().position_ns, 0u);
}

TEST(AnimationTimeline, StreamTimeContinues) {
  Timeline t;
  EXPECT_NEAR(t.timeline.at(-3 * kSecond), -3, 1e-9);
  EXPECT_NEAR(t.timeline.at(kSecond), 1, 1e-9);
  t.now_ns += kSecond / 4;
  EXPECT_NEAR(t.at(), 1.25, 1e-9);
}

}  // namespace
}  // namespace fire3dv::app
