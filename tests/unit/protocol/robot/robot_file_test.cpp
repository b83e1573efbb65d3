// Test that files of robots are refused with the place of their fault, and cost neither time nor memory.
#include <gtest/gtest.h>

#include <unistd.h>
#include <cmath>
#include <cstring>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/protocol/robot/robot_handle.h"

namespace fire3dv::test {
namespace {

using Json = nlohmann::json;

Json valid() {
  return Json::parse(R"({"asset":{"version":"2.0"},"nodes":[{"name":"robot","children":[1,2],
    "extras":{"fire3dv":{"robot":{"version":1,
      "bodies":[{"node":"a"},{"node":"b","parent":"a"}],
      "joints":[{"name":"j","type":"revolute","node":"a","axis":[0,0,1]},{"name":"k","type":"prismatic","node":"b"}]
    }}}},{"name":"a"},{"name":"b"}]})");
}

std::string refusal(const std::string& bytes) {
  fire3dv_robot* robot = fire3dv_read_robot(bytes.data(), bytes.size(), 0);
  EXPECT_FALSE(robot);
  fire3dv_close_robot(&robot);
  return fire3dv_last_error();
}

// Replaces one value of the valid file.
std::string refusal_of(const std::string& pointer, const Json& value) {
  Json file = valid();
  file[Json::json_pointer(pointer)] = value;
  return refusal(file.dump());
}

const std::string kRobot = "/nodes/0/extras/fire3dv/robot";

TEST(RobotFile, TheValidOneIsRead) {
  const RobotHandle robot(std::string_view(valid().dump()));
  EXPECT_EQ(robot.joint_names(), (std::vector<std::string>{"j", "k"}));
  EXPECT_STREQ(robot.joint(1).node, "b");
  EXPECT_EQ(robot.joint(1).type, FIRE3DV_JOINT_PRISMATIC);
}

TEST(RobotFile, FaultsNameTheirPlace) {
  EXPECT_EQ(refusal("{"), refusal("{"));
  EXPECT_NE(refusal("{").find("its JSON is invalid: parse error at line 1, column 2"), std::string::npos);
  EXPECT_NE(refusal("").find("its JSON is invalid"), std::string::npos);
  EXPECT_EQ(refusal("[]"), "it has no nodes");
  EXPECT_NE(refusal(R"({"nodes":[{"name":"a"}]})").find("it holds no joints: convert"), std::string::npos);
  EXPECT_NE(refusal_of(kRobot + "/version", 2).find("robot.version is not 1"), std::string::npos);
  EXPECT_EQ(refusal_of(kRobot + "/bodies", 3), "robot.bodies is not a list");
  EXPECT_EQ(refusal_of(kRobot + "/bodies/1/parent", "c"),
            "robot.bodies[1].parent is \"c\", which is not a body before it");
  EXPECT_EQ(refusal_of(kRobot + "/bodies/0/parent", "b"),
            "robot.bodies[0].parent is \"b\", which is not a body before it");
  EXPECT_EQ(refusal_of(kRobot + "/bodies/1/node", "a"), "there are two bodies \"a\"");
  EXPECT_EQ(refusal_of(kRobot + "/bodies/1/rotation", {0, 0, 0, 0}),
            "robot.bodies[1].rotation has no length");
  EXPECT_EQ(refusal_of(kRobot + "/bodies/1/translation", {0, 0}),
            "robot.bodies[1].translation is not a list of 3 numbers");
  EXPECT_EQ(refusal_of(kRobot + "/bodies/1/translation", {0, 0, 1e13}),
            "robot.bodies[1].translation is not a number of at most 1e12");
  EXPECT_EQ(refusal_of(kRobot + "/joints/1/name", "j"), "there are two joints \"j\"");
  EXPECT_NE(refusal_of(kRobot + "/joints/1/name", "line\nbreak").find("robot.joints[1].name"),
            std::string::npos);
  EXPECT_EQ(refusal_of(kRobot + "/joints/1/node", "c"), "robot.joints[1].node is \"c\", which is not a body");
  EXPECT_EQ(refusal_of(kRobot + "/joints/1/type", "screw"),
            "robot.joints[1].type is \"screw\", which this version does not know");
  EXPECT_EQ(refusal_of(kRobot + "/joints/0/axis", {0, 0, 0}), "robot.joints[0].axis has no length");
  EXPECT_EQ(refusal_of(kRobot + "/joints/0/limits", {1, 0}), "robot.joints[0].limits are not in order");
  EXPECT_EQ(refusal_of(kRobot + "/joints/0/initial", {1, 0}),
            "robot.joints[0].initial is not a list of 1 numbers");
  EXPECT_EQ(refusal_of(kRobot + "/joints/0/mimic", {{"joint", "j"}}),
            "joint \"j\" mimics itself, over other joints");
  EXPECT_EQ(refusal_of(kRobot + "/joints/0/mimic", {{"joint", "x"}}),
            "robot.joints[0].mimic: only revolute and prismatic joints follow each other");
  EXPECT_EQ(refusal_of(kRobot + "/joints/0/mimic", {{"joint", "k"}, {"offset", "1"}}),
            "robot.joints[0].mimic.offset is not a number of at most 1e12");
  EXPECT_EQ(refusal_of(kRobot + "/poses", 1), "robot.poses is not a list");
  EXPECT_EQ(refusal_of(kRobot + "/poses", Json::array({{{"name", "home"}, {"positions", {0}}}})),
            "robot.poses[0].positions is not a list of 2 numbers");
  EXPECT_NE(refusal_of(kRobot + "/poses", Json::array({{{"positions", {0, 0}}}})).find("robot.poses[0].name"),
            std::string::npos);
  EXPECT_EQ(refusal_of(kRobot + "/poses", Json::array({{{"name", "far"}, {"positions", {0, 1e13}}}})),
            "robot.poses[0].positions is not a number of at most 1e12");
  EXPECT_EQ(refusal_of("/nodes/1/extras", valid()["nodes"][0]["extras"]),
            "it holds the joints of several robots: keep one robot in a file");
  EXPECT_EQ(refusal_of("/nodes/1/children", {0}), "its nodes are children of themselves");
}

TEST(RobotFile, LoopsOfMimicAreRefused) {
  Json file = valid();
  Json& joints = file[Json::json_pointer(kRobot + "/joints")];
  joints[0]["mimic"] = {{"joint", "k"}};
  joints[1]["mimic"] = {{"joint", "j"}};
  EXPECT_EQ(refusal(file.dump()), "joint \"j\" mimics itself, over other joints");
}

TEST(RobotFile, DeepValuesAreRefused) {
  EXPECT_EQ(refusal(std::string(1'000'000, '[')), "its JSON is nested more than 64 deep");
  std::string many = "[";
  for (int i = 0; i < 8'000'001; ++i) many += "0,";
  EXPECT_EQ(refusal(many + "0]"), "its JSON has more than 8000000 values");
  EXPECT_EQ(refusal(std::string((size_t{64} << 20) + 1, ' ')), "its JSON is larger than 64 MiB");
}

TEST(RobotFile, DamagedFilesAreSafe) {
  // Numbers, signs and brackets of the valid file are replaced at random; what is still read has finite
  // poses.
  const std::string good = valid().dump();
  const std::string letters = "0123456789-+eE.,:[]{}\"abjknul\\ ";
  std::mt19937 random(1);
  size_t read = 0;
  for (int run = 0; run < 5'000; ++run) {
    std::string damaged = good;
    for (int i = 0; i < 1 + run % 4; ++i)
      damaged[random() % damaged.size()] = letters[random() % letters.size()];
    fire3dv_robot* robot =
        fire3dv_read_robot(damaged.data(), damaged.size(), run % 2 ? FIRE3DV_ROBOT_NO_MIMIC : 0);
    if (!robot) continue;
    ++read;
    fire3dv_description description{};
    description.struct_size = sizeof description;
    EXPECT_EQ(fire3dv_get_robot_description(robot, &description), FIRE3DV_OK);
    std::vector<float> poses(12 * description.node_count);
    EXPECT_EQ(fire3dv_get_poses(robot, poses.data(), description.node_count), FIRE3DV_OK);
    for (const float number : poses) EXPECT_TRUE(std::isfinite(number)) << damaged;
    fire3dv_close_robot(&robot);
  }
  EXPECT_GT(read, 200u);
}

TEST(RobotFile, LongBodyChainIsIterative) {
  Json file = valid();
  Json bodies = Json::array({{{"node", "a"}}});
  for (int i = 1; i < 50'000; ++i)
    bodies.push_back({{"node", "n" + std::to_string(i)},
                      {"parent", i == 1 ? "a" : "n" + std::to_string(i - 1)},
                      {"translation", {1, 0, 0}}});
  bodies[1]["node"] = "b";
  bodies[2]["parent"] = "b";
  file[Json::json_pointer(kRobot + "/bodies")] = bodies;
  const RobotHandle robot(std::string_view(file.dump()));
  EXPECT_EQ(robot.pose("n49999")[3], 49'999);
}

TEST(RobotFile, GlbContainers) {
  const auto glb = [](std::string json, uint32_t version = 2, uint32_t more = 0) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const auto bytes = static_cast<uint32_t>(json.size());
    const uint32_t words[] = {0x46546C67, version, 20 + bytes, bytes + more, 0x4E4F534A};
    std::string file(sizeof words, '\0');
    std::memcpy(file.data(), words, sizeof words);
    return file + json;
  };
  const std::string good = glb(valid().dump());
  const RobotHandle robot{std::string_view(good)};
  EXPECT_EQ(robot.joint_names().size(), 2u);
  EXPECT_EQ(refusal(good.substr(0, 19)), "it ends within its header");
  EXPECT_EQ(refusal(good.substr(0, good.size() - 1)), "its JSON is truncated");
  EXPECT_EQ(refusal(glb(valid().dump(), 2, 0x7ffffff0u)), "its JSON is truncated");
  EXPECT_EQ(refusal(glb(valid().dump(), 1)), "it is glTF 1; version 2 is needed");
  for (size_t length = 0; length < good.size(); ++length) refusal(good.substr(0, length));

  // The same by a file, whose other chunks are not read.
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("robot-" + std::to_string(::getpid()) + ".glb");
  std::ofstream(path, std::ios::binary) << good << "more chunks";
  fire3dv_robot* opened = fire3dv_open_robot(path.c_str(), 0);
  EXPECT_TRUE(opened) << fire3dv_last_error();
  fire3dv_close_robot(&opened);
  std::ofstream(path, std::ios::binary) << "{}";
  EXPECT_FALSE(fire3dv_open_robot(path.c_str(), 0));
  EXPECT_NE(std::string(fire3dv_last_error()).find(path.filename().string()), std::string::npos);
  std::filesystem::remove(path);
  EXPECT_FALSE(fire3dv_open_robot(path.c_str(), 0));
  EXPECT_FALSE(fire3dv_open_robot(nullptr, 0));
  EXPECT_FALSE(fire3dv_open_robot("/tmp", 2));
}

}  // namespace
}  // namespace fire3dv::test
