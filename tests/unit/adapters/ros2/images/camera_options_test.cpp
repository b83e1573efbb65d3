// Options of images: defaults of all cameras, and the choice among the robot's sensors.
#include "adapters/ros2/images/camera_options.h"
#include "adapters/ros2/images/camera_model.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

namespace fire3dv::ros2 {
namespace {

const std::string kRobot =
    "<robot name='r'><link name='eye'/><gazebo reference='eye'>"
    "<sensor name='front' type='camera'><update_rate>15</update_rate></sensor>"
    "<sensor name='rear' type='depth_camera'><topic>/rear/image_raw</topic></sensor></gazebo></robot>";

Result<ImageOptions> parse(std::vector<std::string> words) {
  CLI::App app;
  CameraArguments arguments;
  add_camera_options(app, arguments);
  std::reverse(words.begin(), words.end());
  try {
    app.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    return Error{error.what()};
  }
  return image_options(arguments);
}

ImageOptions good(const std::vector<std::string>& words) {
  Result<ImageOptions> options = parse(words);
  EXPECT_TRUE(options) << (options ? "" : options.error().message);
  return options ? std::move(*options) : ImageOptions{};
}

TEST(CameraOptions, NoneByDefault) {
  EXPECT_TRUE(good({}).is_empty());
  EXPECT_TRUE(robot_cameras(good({}), kRobot, "").cameras.empty());
}

TEST(CameraOptions, DefaultsOfAllCameras) {
  const ImageOptions options = good({"--camera", "a", "--depth", "--image-size", "64x48", "--camera",
                                     "b:=/b/cam,size=10x20,rate=0,depth=false", "--image-rate", "30",
                                     "--labels", "semantic", "--compressed", "--jpeg-quality", "70"});
  ASSERT_EQ(options.cameras.size(), 2u);
  const CameraSpec& a = options.cameras[0];
  const CameraSpec& b = options.cameras[1];
  EXPECT_TRUE(a.depth && a.compressed && b.compressed);
  EXPECT_FALSE(b.depth);
  EXPECT_EQ(a.width, 64u);
  EXPECT_EQ(b.width, 10u);
  EXPECT_EQ(a.rate_hz, 30);
  EXPECT_EQ(b.rate_hz, 0);
  EXPECT_EQ(a.labels, LabelSource::semantic);
  EXPECT_EQ(a.jpeg_quality, 70u);
  EXPECT_EQ(b.topic, "/b/cam");
  EXPECT_FALSE(options.needs_description());
}

TEST(CameraOptions, Refusals) {
  const auto expect = [](const std::vector<std::string>& words, const std::string& part) {
    const Result<ImageOptions> options = parse(words);
    ASSERT_FALSE(options) << part;
    EXPECT_NE(options.error().message.find(part), std::string::npos) << options.error().message;
  };
  expect({"--camera", "a,fov=60"}, "--camera: camera \"a\": fov=\"60\"");
  expect({"--sensor", "a,parent"}, "--sensor: camera \"a\"");
  expect({"--camera", "a", "--image-size", "64"}, "--image-size: \"64\"");
  expect({"--camera", "a", "--labels", "colour"}, "--labels");
  expect({"--depth"}, "need a camera");
  expect({"--jpeg-quality", "0"}, "--jpeg-quality");
  std::vector<std::string> many;
  for (size_t i = 0; i <= kMaxCameras; ++i) many.insert(many.end(), {"--camera", "c" + std::to_string(i)});
  expect(many, "at most 64");
}

TEST(CameraOptions, AllSensors) {
  const RobotCameras cameras = robot_cameras(good({"--sensors", "--compressed"}), kRobot, "r1/");
  EXPECT_TRUE(cameras.warnings.empty());
  ASSERT_EQ(cameras.cameras.size(), 2u);
  EXPECT_EQ(cameras.cameras[0].parent_frame, "r1/eye");
  EXPECT_EQ(cameras.cameras[0].optical_frame, "r1/front_optical_frame");
  EXPECT_EQ(cameras.cameras[0].rate_hz, 15) << "the sensor's, as --image-rate is not given";
  EXPECT_TRUE(cameras.cameras[0].compressed && cameras.cameras[1].compressed);
  EXPECT_FALSE(cameras.cameras[0].depth);
  EXPECT_TRUE(cameras.cameras[1].depth);
  EXPECT_EQ(cameras.cameras[1].topic, "/rear");
}

// The direction of a pixel's ray, hence what is seen, stays when the size changes.
TEST(CameraOptions, SizeScalesProjectionOfSensor) {
  constexpr const char* kWithIntrinsics =
      "<robot name='r'><link name='l'/><gazebo reference='l'><sensor name='eye' type='camera'><camera><image>"
      "<width>320</width><height>240</height></image><lens><intrinsics><fx>200</fx><cx>159.5</cx>"
      "<cy>100</cy></intrinsics></lens></camera></sensor></gazebo></robot>";
  const auto projection = [&](const std::vector<std::string>& words) {
    const RobotCameras cameras = robot_cameras(good(words), kWithIntrinsics, "");
    EXPECT_TRUE(cameras.warnings.empty());
    EXPECT_EQ(cameras.cameras.size(), 1u);
    return cameras.cameras.empty() ? Intrinsics{} : intrinsics(cameras.cameras[0]);
  };
  const auto expect = [](const Intrinsics& k, double fx, double fy, double cx, double cy) {
    EXPECT_DOUBLE_EQ(k.fx, fx);
    EXPECT_DOUBLE_EQ(k.fy, fy);
    EXPECT_DOUBLE_EQ(k.cx, cx);
    EXPECT_DOUBLE_EQ(k.cy, cy);
  };
  expect(projection({"--sensors"}), 200, 200, 159.5, 100);
  expect(projection({"--sensors", "--image-size", "640x480"}), 400, 400, 319.5, 200.5);
  expect(projection({"--sensor", "eye,size=640x240"}), 400, 200, 319.5, 100);
  expect(projection({"--sensor", "eye,size=160x120", "--image-size", "640x480"}), 100, 100, 79.5, 49.75);
  // Values of the same option belong to its size, before or behind it.
  expect(projection({"--sensor", "eye,fx=500,fy=510,size=640x480,cx=300"}), 500, 510, 300, 200.5);
}

TEST(CameraOptions, OneSensorWithSettings) {
  const ImageOptions options =
      good({"--sensor", "rear:=/cam,rate=5", "--sensor", "top", "--image-rate", "30"});
  EXPECT_TRUE(options.needs_description());
  const RobotCameras cameras = robot_cameras(options, kRobot, "");
  ASSERT_EQ(cameras.cameras.size(), 1u);
  EXPECT_EQ(cameras.cameras[0].name, "rear");
  EXPECT_EQ(cameras.cameras[0].topic, "/cam");
  EXPECT_EQ(cameras.cameras[0].rate_hz, 5);
  ASSERT_EQ(cameras.warnings.size(), 1u);
  EXPECT_EQ(cameras.warnings[0], "the robot description has no camera \"top\"; it has front, rear");
  EXPECT_EQ(robot_cameras(options, "<robot", "").warnings.size(), 1u);
}

}  // namespace
}  // namespace fire3dv::ros2
