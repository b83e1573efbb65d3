// Owning handle of a robot, and its poses, for tests.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fire3dv/joints.h"

namespace fire3dv::test {

using Pose12 = std::array<double, 12>;  // 3x4, row-major

class RobotHandle {
 public:
  explicit RobotHandle(std::span<const std::byte> bytes, uint32_t flags = 0)
      : robot_(fire3dv_read_robot(bytes.data(), bytes.size(), flags)) {
    EXPECT_TRUE(robot_) << fire3dv_last_error();
  }
  explicit RobotHandle(std::string_view json, uint32_t flags = 0)
      : RobotHandle(std::as_bytes(std::span(json)), flags) {}
  ~RobotHandle() { fire3dv_close_robot(&robot_); }
  RobotHandle(const RobotHandle&) = delete;
  RobotHandle& operator=(const RobotHandle&) = delete;

  fire3dv_robot* get() const { return robot_; }

  void set(const std::vector<double>& positions, uint32_t flags = 0) {
    EXPECT_EQ(fire3dv_set_positions(robot_, positions.data(), positions.size(), flags), FIRE3DV_OK)
        << fire3dv_last_error();
  }
  std::vector<double> positions() const {
    std::vector<double> all(fire3dv_position_count(robot_));
    EXPECT_EQ(fire3dv_get_positions(robot_, all.data(), all.size()), FIRE3DV_OK) << fire3dv_last_error();
    return all;
  }
  Pose12 pose(const std::string& node) const {
    Pose12 pose{};
    EXPECT_EQ(fire3dv_get_node_pose(robot_, node.c_str(), pose.data()), FIRE3DV_OK) << fire3dv_last_error();
    return pose;
  }
  fire3dv_joint joint(size_t index) const {
    fire3dv_joint joint{};
    joint.struct_size = sizeof joint;
    EXPECT_EQ(fire3dv_get_joint(robot_, index, &joint), FIRE3DV_OK) << fire3dv_last_error();
    return joint;
  }
  std::vector<std::string> joint_names() const {
    std::vector<std::string> names;
    for (size_t i = 0; i < fire3dv_joint_count(robot_); ++i) names.emplace_back(joint(i).name);
    return names;
  }

 private:
  fire3dv_robot* robot_;
};

inline void expect_near(const Pose12& a, const Pose12& b, double tolerance, const std::string& what) {
  for (size_t i = 0; i < 12; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << what << ", element " << i;
}

}  // namespace fire3dv::test
