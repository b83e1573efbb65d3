// Store of markers, with fake frames and a fake renderer.
#include "adapters/ros2/markers/marker_store.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace fire3dv::ros2 {
namespace {

constexpr int64_t kSecond = 1'000'000'000;
const std::string kTopic = "viz";

struct Drawn {
  std::array<float, 3> place;
  uint64_t lifetime_ns;
  size_t points;
};

class Ros2MarkerStore : public testing::Test {
 protected:
  Ros2MarkerStore() {
    context.fixed_frame = "odom";
    context.sim_time_ns = 100 * kSecond;
    context.find_transform = [this](const std::string& frame) {
      const auto found = frames.find(frame);
      return found == frames.end() ? nullptr : &found->second;
    };
    context.show = [this](const std::string& name, const fire3dv_marker* marker) -> Result<void> {
      ++calls;
      if (!marker) {
        drawn.erase(name);
        return {};
      }
      if (marker->position_count > max_points) return Error{"the budget is spent"};
      const float* const pose = marker->parent_from_marker;
      drawn[name] = {{pose[3], pose[7], pose[11]}, marker->lifetime_ns, marker->position_count};
      return {};
    };
    context.warn = [this](const std::string&, const std::string& text) { warnings.push_back(text); };
    frames["odom"] = {};
  }

  static ShownMarker marker(const std::string& name, const std::string& frame, int64_t lifetime_ns = 0,
                            size_t points = 1) {
    ShownMarker result;
    result.name = kTopic + "/" + name;
    result.frame = frame;
    result.frame_from_marker.translation = {0, 0, 1};
    result.lifetime_ns = static_cast<uint64_t>(lifetime_ns);
    result.positions.assign(3 * points, 0.0f);
    result.colors = {255, 0, 0, 255};
    return result;
  }
  void set(ShownMarker&& shown) { store.set(kTopic, std::move(shown), context); }
  // Both clocks go on.
  void go_on(double seconds) {
    const auto step = static_cast<int64_t>(seconds * static_cast<double>(kSecond));
    context.now_ns += step;
    if (context.sim_time_ns) *context.sim_time_ns += step;
    store.update(context);
  }
  static Transform at(double x) {
    Transform transform;
    transform.translation = {x, 0, 0};
    return transform;
  }

  MarkerStore store;
  MarkerContext context;
  std::map<std::string, Transform> frames;
  std::map<std::string, Drawn> drawn;
  std::vector<std::string> warnings;
  size_t calls = 0, max_points = 1'000'000;
};

using Place = std::array<float, 3>;

TEST_F(Ros2MarkerStore, MarkerUsesFramesPose) {
  frames["base"] = at(5);
  store.update(context);
  set(marker("a", "base"));
  EXPECT_EQ(drawn.at("viz/a").place, (Place{5, 0, 1}));
  frames["base"] = at(6);
  go_on(1);
  EXPECT_EQ(drawn.at("viz/a").place, (Place{5, 0, 1}));
  EXPECT_EQ(calls, 1u);
  store.clear(kTopic, "viz/a", context);
  EXPECT_TRUE(drawn.empty());
  store.clear(kTopic, "viz/a", context);  // not there any more
  EXPECT_EQ(calls, 2u);
  EXPECT_TRUE(warnings.empty());
}

TEST_F(Ros2MarkerStore, LockedMarkersFollowTheirFrames) {
  frames["base"] = at(5);
  store.update(context);
  ShownMarker locked = marker("a", "base");
  locked.is_frame_locked = true;
  set(ShownMarker(locked));
  set(marker("b", "base"));
  go_on(1);
  const size_t before = calls;
  go_on(1);
  EXPECT_EQ(calls, before);  // the frame rests
  frames["base"] = at(6);
  go_on(1);
  EXPECT_EQ(drawn.at("viz/a").place, (Place{6, 0, 1}));
  EXPECT_EQ(drawn.at("viz/b").place, (Place{5, 0, 1}));
  frames.erase("base");
  go_on(1);
  EXPECT_EQ(drawn.at("viz/a").place, (Place{6, 0, 1}));
  frames["base"] = at(7);
  locked.is_frame_locked = false;  // a message replaces it
  set(ShownMarker(locked));
  frames["base"] = at(8);
  go_on(1);
  EXPECT_EQ(drawn.at("viz/a").place, (Place{7, 0, 1}));
  locked.is_frame_locked = true;
  set(ShownMarker(locked));
  store.clear(kTopic, "viz/a", context);
  frames["base"] = at(9);
  go_on(1);
  EXPECT_FALSE(drawn.contains("viz/a"));
}

TEST_F(Ros2MarkerStore, ExpiredMarkersMakeRoom) {
  store = MarkerStore({.markers_per_topic = 3, .held_bytes = 1 << 20});
  store.update(context);
  for (const char* name : {"a", "b", "c"}) set(marker(name, "odom", 2 * kSecond));
  EXPECT_EQ(drawn.at("viz/a").lifetime_ns, 2u * kSecond);
  set(marker("d", "odom"));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("3 markers already"), std::string::npos) << warnings[0];
  go_on(2);
  EXPECT_EQ(drawn.size(), 3u);
  go_on(0.001);
  EXPECT_TRUE(drawn.empty()) << "their edits are cleared";
  EXPECT_EQ(store.size(kTopic), 0u);
  set(marker("d", "odom"));
  EXPECT_EQ(drawn.size(), 1u);
}

TEST_F(Ros2MarkerStore, ReplacementHasOwnLifetime) {
  store.update(context);
  set(marker("a", "odom", 1 * kSecond));
  set(marker("b", "odom", 1 * kSecond));
  go_on(0.5);
  set(marker("a", "odom", 1 * kSecond));
  set(marker("b", "odom"));
  go_on(0.75);
  EXPECT_EQ(drawn.size(), 2u);
  go_on(0.5);
  EXPECT_EQ(drawn.size(), 1u);
  EXPECT_TRUE(drawn.contains("viz/b"));
}

TEST_F(Ros2MarkerStore, LifetimesUseSimulatedTime) {
  store.update(context);
  set(marker("a", "odom", 1 * kSecond));
  context.now_ns += 1000 * kSecond;  // a paused simulator
  store.update(context);
  EXPECT_EQ(drawn.size(), 1u);
  *context.sim_time_ns -= 1;  // it was restarted
  store.update(context);
  EXPECT_TRUE(drawn.empty());
  EXPECT_EQ(store.size(kTopic), 0u);
}

TEST_F(Ros2MarkerStore, LifetimesStartWithTime) {
  context.sim_time_ns.reset();
  store.update(context);
  set(marker("a", "odom", 1 * kSecond));
  set(marker("b", "odom"));
  EXPECT_TRUE(drawn.contains("viz/b"));
  EXPECT_FALSE(drawn.contains("viz/a")) << "the renderer counts from the last frame";
  context.sim_time_ns = 500 * kSecond;
  store.update(context);
  EXPECT_EQ(drawn.at("viz/a").lifetime_ns, 1u * kSecond);
  EXPECT_EQ(store.held_bytes(), 0u);
  go_on(1.5);
  EXPECT_FALSE(drawn.contains("viz/a"));
  EXPECT_TRUE(warnings.empty());
}

TEST_F(Ros2MarkerStore, FixedFrameMovesAll) {
  frames["base"] = at(5);
  store.update(context);
  set(marker("a", "base"));
  set(marker("b", "odom", 10 * kSecond));
  go_on(1);
  context.fixed_frame = "map";
  frames = {{"map", {}}, {"odom", at(100)}, {"base", at(107)}};  // the robot has moved by 2 m
  store.update(context);
  EXPECT_EQ(drawn.at("viz/a").place, (Place{105, 0, 1}));
  EXPECT_EQ(drawn.at("viz/b").place, (Place{100, 0, 1}));
  EXPECT_EQ(drawn.at("viz/b").lifetime_ns, 9u * kSecond) << "what is left of it";
  go_on(8.5);
  EXPECT_TRUE(drawn.contains("viz/b"));
  go_on(1);
  EXPECT_FALSE(drawn.contains("viz/b"));
  // The old fixed frame is gone: by the markers' own frames, or not at all.
  set(marker("c", "odom"));
  context.fixed_frame = "world";
  frames = {{"world", {}}, {"base", at(3)}};
  store.update(context);
  EXPECT_EQ(drawn.at("viz/a").place, (Place{3, 0, 1}));
  EXPECT_FALSE(drawn.contains("viz/c"));
  frames["odom"] = at(7);
  go_on(0.2);
  EXPECT_EQ(drawn.at("viz/c").place, (Place{7, 0, 1}));
}

TEST_F(Ros2MarkerStore, MarkersAwaitFrames) {
  store.update(context);
  set(marker("map", "map"));
  set(marker("short", "map", 1 * kSecond));
  EXPECT_TRUE(drawn.empty());
  EXPECT_GT(store.held_bytes(), 0u);
  go_on(2.9);
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(store.size(kTopic), 1u) << "a lifetime ends without a place, too";
  go_on(0.2);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("frame \"map\" is not connected to the fixed frame \"odom\""),
            std::string::npos);
  go_on(10);
  EXPECT_EQ(warnings.size(), 1u) << "once";
  frames["map"] = at(-4);
  go_on(0.2);
  EXPECT_EQ(drawn.at("viz/map").place, (Place{-4, 0, 1}));
  EXPECT_EQ(store.held_bytes(), 0u);
}

TEST_F(Ros2MarkerStore, TheNewestMessageCounts) {
  store.update(context);
  set(marker("a", "odom"));
  set(marker("a", "nowhere"));
  EXPECT_TRUE(drawn.empty()) << "the old place is out of date";
  set(marker("a", "nowhere", 0, 2));
  set(marker("a", "odom", 0, 3));
  EXPECT_EQ(drawn.at("viz/a").points, 3u);
  EXPECT_EQ(store.held_bytes(), 0u);
  set(marker("b", "nowhere"));
  store.clear_topic(kTopic, context);
  EXPECT_TRUE(drawn.empty());
  EXPECT_EQ(store.size(kTopic), 0u);
  EXPECT_EQ(store.held_bytes(), 0u);
  go_on(5);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

TEST_F(Ros2MarkerStore, HeldMarkersHaveBudget) {
  store = MarkerStore({.markers_per_topic = 100, .held_bytes = size_t{3} << 20});
  store.update(context);
  const size_t points = 80'000;  // 960 kB
  for (const char* name : {"a", "b", "c"}) set(marker(name, "late", 0, points));
  EXPECT_TRUE(warnings.empty());
  set(marker("d", "late", 0, points));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("\"viz/a\" is dropped"), std::string::npos) << warnings[0];
  EXPECT_LE(store.held_bytes(), size_t{3} << 20);
  set(marker("huge", "late", 0, 10 * points));
  EXPECT_EQ(store.size(kTopic), 0u);
  EXPECT_EQ(store.held_bytes(), 0u);
  set(marker("e", "late"));
  frames["late"] = {};
  go_on(1);
  EXPECT_EQ(drawn.size(), 1u);
}

TEST_F(Ros2MarkerStore, RefusalsAreReported) {
  max_points = 5;
  store.update(context);
  set(marker("a", "odom"));
  set(marker("a", "odom", 3 * kSecond, 6));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("the budget is spent"), std::string::npos);
  EXPECT_TRUE(drawn.empty()) << "the old one is out of date";
  EXPECT_EQ(store.size(kTopic), 0u);
  set(marker("b", std::string(300, 'x')));
  EXPECT_EQ(warnings.size(), 2u);
  EXPECT_EQ(store.held_bytes(), 0u);
  go_on(10);
  EXPECT_EQ(warnings.size(), 2u);
}

}  // namespace
}  // namespace fire3dv::ros2
