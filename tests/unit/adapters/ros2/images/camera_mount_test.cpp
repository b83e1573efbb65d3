// Mounts of cameras: static transforms up to a node of the stream, nodes with a scale, loops, frames that tf
// lacks.
#include "adapters/ros2/images/camera_mount.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <string>

namespace fire3dv::ros2 {
namespace {

constexpr double kHalf = 0.70710678118654752;  // of a quarter turn

class CameraMountTest : public testing::Test {
 protected:
  void add(const std::string& parent, const std::string& child, const Transform& transform, bool is_static) {
    ASSERT_EQ(buffer_.insert(parent, child, is_static ? 0 : ++stamp_, transform, is_static, 1, 1),
              Insertion::accepted);
  }
  std::optional<CameraMount> find(const std::string& frame) const {
    StreamedFrames streamed;
    streamed.fixed = buffer_.find("map");
    streamed.frame_prefix = prefix_;
    streamed.has_node = [&](const std::string& node) { return nodes_.contains(node); };
    streamed.offset_of = [&](const std::string& node) -> const Pose* {
      const auto& offset = nodes_.at(node);
      return offset ? &*offset : nullptr;
    };
    streamed.name_of = [](const std::string& node) { return "robot/" + node; };
    return find_camera_mount(buffer_, streamed, frame);
  }

  FrameBuffer buffer_;
  std::map<std::string, std::optional<Pose>> nodes_;
  std::string prefix_;
  int64_t stamp_ = 0;
};

// Rotation and translation, 3x4.
void expect_near(const Matrix34& matrix, const Matrix34& expected) {
  for (size_t i = 0; i < matrix.size(); ++i) EXPECT_NEAR(matrix[i], expected[i], 1e-6) << i;
}

TEST_F(CameraMountTest, StaticTransformsAreClimbed) {
  nodes_["arm"];
  add("map", "arm", {{5, 0, 0}, {0, 0, 0, 1}}, false);
  add("arm", "bracket", {{0, 0, 1}, {0, 0, kHalf, kHalf}}, true);  // turned left
  add("bracket", "optical", {{2, 0, 0}, {0, 0, 0, 1}}, true);
  const auto mount = find("optical");
  ASSERT_TRUE(mount);
  EXPECT_EQ(mount->node, "robot/arm");
  expect_near(mount->node_from_frame, {0, -1, 0, 0, 1, 0, 0, 2, 0, 0, 1, 1});
  EXPECT_EQ(find("arm")->node_from_frame, CameraMount{}.node_from_frame);
}

TEST_F(CameraMountTest, FixedFrameIsStreams) {
  add("map", "tripod", {{1, 2, 3}, {0, 0, 0, 1}}, true);
  const auto mount = find("tripod");
  ASSERT_TRUE(mount);
  EXPECT_EQ(mount->node, "");
  expect_near(mount->node_from_frame, {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3});
  EXPECT_EQ(find("map")->node, "");
}

TEST_F(CameraMountTest, ForeignFramesAreNoNodes) {
  prefix_ = "robot1/";
  nodes_["arm"];
  add("map", "robot1/arm", {}, false);
  add("map", "robot2/arm", {}, false);
  add("map", "arm", {}, false);
  EXPECT_EQ(find("robot1/arm")->node, "robot/arm");
  EXPECT_FALSE(find("robot2/arm"));
  EXPECT_FALSE(find("arm"));
}

TEST_F(CameraMountTest, ScaledNodeIsUndone) {
  nodes_["mesh"] = Pose{0.001f, 0, 0, 0, 0, 0.001f, 0, 0, 0, 0, 0.001f, 0.5f};
  add("map", "mesh", {}, false);
  add("mesh", "eye", {{1, 0, 0}, {0, 0, 0, 1}}, true);
  const auto mount = find("eye");
  ASSERT_TRUE(mount);
  // node = (body - 0.5 z) / 0.001
  EXPECT_NEAR(mount->node_from_frame[0], 1000, 1e-2);
  EXPECT_NEAR(mount->node_from_frame[3], 1000, 1e-2);
  EXPECT_NEAR(mount->node_from_frame[11], -500, 1e-2);
  nodes_["mesh"] = Pose{};  // flat
  EXPECT_FALSE(find("eye"));
}

TEST_F(CameraMountTest, UnresolvableFrameHasNoMount) {
  nodes_["arm"];
  EXPECT_FALSE(find("nowhere"));
  EXPECT_FALSE(find(""));
  add("map", "gantry", {}, false);
  add("gantry", "eye", {}, true);
  EXPECT_FALSE(find("eye")) << "the gantry moves and is no node";
  add("a", "b", {}, true);
  add("b", "a", {}, true);
  EXPECT_FALSE(find("a")) << "a loop has an end";
}

}  // namespace
}  // namespace fire3dv::ros2
