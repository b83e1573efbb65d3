// Node paths of a converted robot, and the watch of /clock.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstddef>
#include <string>
#include <vector>

#include "adapters/ros2/renderers.h"
#include "adapters/ros2/robot/node_paths.h"
#include "adapters/ros2/tf/clock_watch.h"
#include "base/glb.h"

namespace fire3dv::ros2 {
namespace {

std::vector<uint8_t> glb(const std::string& json) {
  std::vector<uint8_t> bytes;
  for (const std::byte byte : base::make_glb(json, {})) bytes.push_back(static_cast<uint8_t>(byte));
  return bytes;
}

TEST(Ros2Robot, NodePathsAreEscaped) {
  const auto paths = node_paths(glb(R"json({"nodes": [
      {"name": "r (scene)", "children": [1, 2]}, {"name": "a/b", "children": [3]}, {"name": "c~d"},
      {"name": "e", "children": [1, 3, 99, -1, "x"]}, {"name": "f"}]})json"));
  EXPECT_EQ(paths.at("r (scene)"), "r (scene)");
  EXPECT_EQ(paths.at("a/b"), "r (scene)/a~1b");
  EXPECT_EQ(paths.at("c~d"), "r (scene)/c~0d");
  EXPECT_EQ(paths.at("f"), "f");
}

// The stream goes on without a robot that is larger than its budget, and says so once.
TEST(Ros2Robot, OversizedRobotIsNotSent) {
  const std::string uri = "shm://fire3dv-ros2-robot-" + std::to_string(::getpid());
  Result<Renderers> renderers = Renderers::open({uri}, {}, 1 << 20);
  ASSERT_TRUE(renderers) << renderers.error().message;
  std::vector<std::string> lines;
  const auto poll = [&] {
    lines.clear();
    ASSERT_TRUE(renderers->poll([&](const std::string& line) { lines.push_back(line); }));
  };
  ASSERT_TRUE(renderers->set_robot(std::vector<uint8_t>((1 << 20) + 1)));
  poll();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("1048577 bytes, and a stream at most 1048576"), std::string::npos) << lines[0];
  EXPECT_NE(lines[0].find("--write-scene"), std::string::npos) << lines[0];
  poll();
  EXPECT_TRUE(lines.empty());
  ASSERT_TRUE(renderers->describe({"base"}, {}));
  ASSERT_TRUE(renderers->publish(1, {Pose{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}, false));
  ASSERT_TRUE(renderers->set_robot(glb("{}")));
  poll();
  EXPECT_TRUE(lines.empty());
}

TEST(Ros2Robot, InvalidBytesHaveNoPath) {
  EXPECT_TRUE(node_paths({}).empty());
  EXPECT_TRUE(node_paths(glb("[]")).empty());
  EXPECT_TRUE(node_paths(glb(R"json({"nodes":{"a":1}})json")).empty());
  EXPECT_TRUE(node_paths(glb(R"json({"nodes":)json")).empty());
  node_paths(glb(R"json({"nodes":[1,null,{"name":2,"children":"x"},{"children":[3]}]})json"));
  std::vector<uint8_t> bytes = glb(R"json({"nodes":[{"name":"a"}]})json");
  EXPECT_EQ(node_paths(bytes).size(), 1u);
  bytes[12] = bytes[13] = bytes[14] = bytes[15] = 0xff;
  EXPECT_TRUE(node_paths(bytes).empty());
  for (size_t size = 0; size < bytes.size(); ++size) node_paths(std::span(bytes).first(size));
}

TEST(Ros2Clock, LargeStepBackIsReset) {
  constexpr int64_t kMs = 1'000'000;
  using Event = ClockWatch::Event;
  ClockWatch clock;
  EXPECT_EQ(clock.add(5000 * kMs, 1, 0), Event::none);
  EXPECT_EQ(clock.add(4001 * kMs, 1, 1), Event::none);
  EXPECT_EQ(clock.add(5500 * kMs, 1, 2), Event::none);
  EXPECT_EQ(clock.add(4400 * kMs, 1, 3), Event::jumped_back);
  EXPECT_EQ(clock.add(50 * kMs, 1, 4), Event::jumped_back);
  EXPECT_EQ(clock.add(20 * kMs, 1, 5), Event::none);
  EXPECT_EQ(clock.add(900 * kMs, 1, 6), Event::none);
  EXPECT_EQ(clock.add(99 * kMs, 1, 7), Event::jumped_back);
}

TEST(Ros2Clock, FirstPublisherCountsUntilSilent) {
  constexpr int64_t kSecond = 1'000'000'000;
  using Event = ClockWatch::Event;
  ClockWatch clock;
  EXPECT_EQ(clock.add(100 * kSecond, 1, 0), Event::none);
  EXPECT_EQ(clock.add(1 * kSecond, 2, 1), Event::conflict);
  EXPECT_EQ(clock.time_ns(), 100 * kSecond);
  EXPECT_EQ(clock.add(2 * kSecond, 2, 3 * kSecond), Event::jumped_back);
  EXPECT_EQ(clock.source(), 2u);
}

}  // namespace
}  // namespace fire3dv::ros2
