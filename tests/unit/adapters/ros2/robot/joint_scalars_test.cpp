// Test of joint states as scalars: order, units and times of the groups, and messages that are refused.
#include <fire3dv/joints.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "adapters/ros2/robot/joint_scalars.h"

namespace fire3dv::ros2 {
namespace {

constexpr int64_t kSecond = 1'000'000'000;
using Names = std::vector<std::string_view>;
using Numbers = std::vector<double>;

std::vector<ScalarGroup*> taken(JointScalars& scalars, const Names& names, const Numbers& positions,
                                int64_t stamp_ns, const Numbers& velocities = {},
                                const Numbers& efforts = {}) {
  const auto groups = scalars.take({names, positions, velocities, efforts, stamp_ns});
  EXPECT_TRUE(groups.ok()) << (groups.ok() ? "" : groups.error().message);
  return groups.ok() ? *groups : std::vector<ScalarGroup*>();
}

TEST(JointScalars, UnitsFollowJointTypes) {
  JointScalars scalars;
  scalars.set_joint_types({{"turn", FIRE3DV_JOINT_REVOLUTE}, {"lift", FIRE3DV_JOINT_PRISMATIC}});
  auto groups = taken(scalars, {"turn", "lift", "alien"}, {1, 2, 3}, 5, {4, 5, 6}, {7, 8, 9});
  ASSERT_EQ(groups.size(), 3u);
  EXPECT_EQ(groups[0]->name, "joint_positions");
  EXPECT_EQ(groups[1]->name, "joint_velocities");
  EXPECT_EQ(groups[2]->name, "joint_efforts");
  EXPECT_EQ(groups[0]->units, (std::vector<std::string>{"rad", "m", ""}));
  EXPECT_EQ(groups[1]->units, (std::vector<std::string>{"rad/s", "m/s", ""}));
  EXPECT_EQ(groups[2]->units, (std::vector<std::string>{"N m", "N", ""}));
  EXPECT_EQ(groups[2]->values, (Numbers{7, 8, 9}));
  for (ScalarGroup* group : groups) group->is_declared = true;
  // The same joints in another order, without velocities, and with efforts of too few.
  groups = taken(scalars, {"alien", "turn", "lift"}, {30, 10, 20}, 6, {}, {1, 2});
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0]->names, (std::vector<std::string>{"turn", "lift", "alien"}));
  EXPECT_EQ(groups[0]->values, (Numbers{10, 20, 30}));
  EXPECT_EQ(groups[0]->time_ns, 6);
  EXPECT_TRUE(groups[0]->is_declared);
  // Another description of the robot: only changed units are declared anew.
  scalars.set_joint_types({{"turn", FIRE3DV_JOINT_REVOLUTE}, {"lift", FIRE3DV_JOINT_PRISMATIC}});
  EXPECT_TRUE(groups[0]->is_declared);
  scalars.set_joint_types({{"turn", FIRE3DV_JOINT_PRISMATIC}});
  EXPECT_FALSE(groups[0]->is_declared);
  EXPECT_EQ(groups[0]->units, (std::vector<std::string>{"m", "", ""}));
}

TEST(JointScalars, PublishersKeepTheirTimes) {
  JointScalars scalars;
  EXPECT_EQ(taken(scalars, {"a"}, {1}, 10 * kSecond).at(0)->name, "joint_positions");
  EXPECT_EQ(taken(scalars, {"b"}, {1}, 9 * kSecond).at(0)->name, "joint_positions 2");
  EXPECT_EQ(taken(scalars, {"b"}, {2}, 9 * kSecond + 1).at(0)->time_ns, 9 * kSecond + 1);
  EXPECT_EQ(taken(scalars, {"a"}, {2}, 10 * kSecond).size(), 1u) << "times may repeat";
  EXPECT_TRUE(taken(scalars, {"a"}, {3}, 10 * kSecond - 1).empty()) << "a late message";
  EXPECT_EQ(taken(scalars, {"a"}, {4}, 9 * kSecond).size(), 1u) << "a second back";
  scalars.restart();
  EXPECT_EQ(taken(scalars, {"a"}, {5}, 9 * kSecond - 1).size(), 1u);
  // A group that the stream refused is left alone.
  taken(scalars, {"a"}, {5}, 9 * kSecond).at(0)->is_refused = true;
  EXPECT_TRUE(taken(scalars, {"a"}, {5}, 9 * kSecond).empty());
  EXPECT_EQ(taken(scalars, {"b"}, {5}, 9 * kSecond + 2).size(), 1u);
}

TEST(JointScalars, InvalidMessagesAreRefused) {
  JointScalars scalars;
  const auto fault = [&](const Names& names) {
    const Numbers numbers(names.size());
    const auto groups = scalars.take({names, numbers, {}, {}, 1});
    return groups.ok() ? std::string() : groups.error().message;
  };
  EXPECT_TRUE(taken(scalars, {}, {1, 2}, 1).empty());
  EXPECT_TRUE(taken(scalars, {"a"}, {}, 1).empty());
  EXPECT_NE(fault({"b", "a", "b"}).find("\"b\" is twice"), std::string::npos);
  EXPECT_NE(fault({"a", ""}).find("0 bytes"), std::string::npos);
  const std::string large(1025, 'x');
  EXPECT_NE(fault({large}).find("1025 bytes"), std::string::npos);
  EXPECT_NE(fault(Names(5000, "a")).find("5000 joints"), std::string::npos);
  std::vector<std::string> many;
  for (size_t i = 0; i < JointScalars::kMaxSets; ++i) many.push_back("joint " + std::to_string(i));
  for (size_t i = 0; i + 1 < many.size(); ++i) EXPECT_EQ(fault({many[i]}), "");  // "a" is the first set
  EXPECT_NE(fault({many.back()}).find("16 different sets"), std::string::npos);
  EXPECT_EQ(fault({many.front()}), "");
  // A number that is none is no value, and does not hide the others.
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(taken(scalars, {"a"}, {nan}, 2).at(0)->values.at(0)));
}

}  // namespace
}  // namespace fire3dv::ros2
