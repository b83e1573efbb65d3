// Cameras of fire3dv-ros2: the grammar of --camera, projection, CameraInfo and frames. Oracle of rotations:
// urdfdom.
#include <gtest/gtest.h>
#include <urdf_model/pose.h>

#include <cmath>
#include <numbers>

#include "adapters/ros2/images/camera_model.h"
#include "adapters/ros2/images/camera_spec.h"

namespace fire3dv::ros2 {
namespace {

CameraSpec camera(std::string_view text, CameraSpec defaults = {}) {
  const Result<CameraOption> option = parse_camera_option(text);
  EXPECT_TRUE(option) << (option ? "" : option.error().message);
  const Result<CameraSpec> spec = apply(*option, std::move(defaults));
  EXPECT_TRUE(spec) << (spec ? "" : spec.error().message);
  return *spec;
}

std::string refusal(std::string_view text) {
  const Result<CameraOption> option = parse_camera_option(text);
  return option ? "accepted" : option.error().message;
}

TEST(CameraSpec, NameAloneUsesItsFrame) {
  const CameraSpec spec = camera("front");
  EXPECT_EQ(spec.topic, "front");
  EXPECT_EQ(spec.parent_frame, "front");
  EXPECT_EQ(spec.optical_frame, "front_optical_frame");
  EXPECT_TRUE(spec.publishes_frame);
  EXPECT_EQ(spec.width, 640u);
  EXPECT_EQ(spec.height, 480u);
  EXPECT_FALSE(spec.depth || spec.compressed || spec.labels != LabelSource::none);
}

TEST(CameraSpec, AllKeys) {
  const CameraSpec spec = camera(
      "front:=/cam/front,parent=/tool0,xyz=0.1 -2e-1 +3,rpy=0 0.4 "
      "-1,size=1280x720,fx=900,fy=901,cx=640,cy=0,near=0.2,"
      "far=50,plumb_bob=.1 .2 .3 .4 .5,rate=15,depth,labels=semantic,compressed=true,quality=80,optical=eye");
  EXPECT_EQ(spec.topic, "/cam/front");
  EXPECT_EQ(spec.parent_frame, "tool0");
  EXPECT_EQ(spec.optical_frame, "eye");
  EXPECT_TRUE(spec.publishes_frame);
  EXPECT_EQ(spec.xyz, (std::array<double, 3>{0.1, -0.2, 3}));
  EXPECT_EQ(spec.rpy, (std::array<double, 3>{0, 0.4, -1}));
  EXPECT_EQ(spec.width, 1280u);
  EXPECT_EQ(spec.height, 720u);
  const Intrinsics k = intrinsics(spec);
  EXPECT_EQ(k.fx, 900);
  EXPECT_EQ(k.fy, 901);
  EXPECT_EQ(k.cx, 640);
  EXPECT_EQ(k.cy, 0);
  EXPECT_EQ(spec.near_m, 0.2);
  EXPECT_EQ(spec.far_m, 50);
  EXPECT_EQ(spec.lens, Lens::plumb_bob);
  EXPECT_EQ(spec.lens_coefficients, (std::array<double, 5>{.1, .2, .3, .4, .5}));
  EXPECT_EQ(spec.rate_hz, 15);
  EXPECT_TRUE(spec.depth && spec.compressed);
  EXPECT_EQ(spec.labels, LabelSource::semantic);
  EXPECT_EQ(spec.jpeg_quality, 80u);
}

TEST(CameraSpec, OpticalFrameComesFromTf) {
  const CameraSpec spec = camera("front,optical=camera_color_optical_frame");
  EXPECT_EQ(spec.parent_frame, "camera_color_optical_frame");
  EXPECT_EQ(spec.optical_frame, "camera_color_optical_frame");
  EXPECT_FALSE(spec.publishes_frame);
  EXPECT_EQ(parent_from_optical(spec), (Matrix34{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}));
}

TEST(CameraSpec, DefaultsAreKeptAndOverridden) {
  CameraSpec defaults;
  defaults.depth = defaults.compressed = true;
  defaults.width = 64;
  defaults.height = 48;
  defaults.rate_hz = 30;
  const CameraSpec spec = camera("front,depth=false,labels", defaults);
  EXPECT_FALSE(spec.depth);
  EXPECT_TRUE(spec.compressed);
  EXPECT_EQ(spec.labels, LabelSource::instance);
  EXPECT_EQ(spec.width, 64u);
  EXPECT_EQ(spec.rate_hz, 30);
}

TEST(CameraSpec, SettingsOfASensor) {
  CameraSpec sensor;
  sensor.name = "head";
  sensor.topic = "/head/camera";
  sensor.parent_frame = "head_link";
  sensor.optical_frame = "head_optical";
  sensor.publishes_frame = false;
  sensor.xyz = {1, 2, 3};
  sensor.fx = 100;
  EXPECT_EQ(camera("head,rate=5", sensor).optical_frame, "head_optical");
  EXPECT_FALSE(camera("head,rate=5", sensor).publishes_frame);
  EXPECT_EQ(camera("head", sensor).topic, "/head/camera");
  EXPECT_EQ(camera("head:=other", sensor).topic, "other");
  EXPECT_EQ(camera("head,fov=1", sensor).fx, 0) << "an angle replaces the sensor's focal length";
  const CameraSpec moved = camera("head,parent=base", sensor);
  EXPECT_EQ(moved.xyz, (std::array<double, 3>{})) << "the sensor's pose belongs to its own link";
  EXPECT_EQ(moved.optical_frame, "head_optical_frame") << "the robot's frame is elsewhere";
  EXPECT_TRUE(moved.publishes_frame);
}

TEST(CameraSpec, Refusals) {
  const auto expect = [](std::string_view text, std::string_view part) {
    const std::string message = refusal(text);
    EXPECT_NE(message.find(part), std::string::npos) << text << ": " << message;
  };
  expect("", "needs a name");
  expect(":=/a", "needs a name");
  expect("a:=", "not a topic name");
  expect("a:=/b//c", "not a topic name");
  expect("a:=/b-c", "not a topic name");
  expect("a:=" + std::string(201, 'x'), "not a topic name");
  expect("a,fov=60", "radians");
  expect("a,fov=0", "radians");
  expect("a,fov=nan", "radians");
  expect("a,size=0x480", "expected WIDTHxHEIGHT");
  expect("a,size=640x480x3", "expected WIDTHxHEIGHT");
  expect("a,size=99999x1", "8192");
  expect("a,xyz=1 2", "three numbers");
  expect("a,xyz=1 2 3 4", "three numbers");
  expect("a,xyz=1 2 inf", "three numbers");
  expect("a,rpy=0-1 2", "three angles");
  expect("a,near=1,far=0.5", "far must be more than near");
  expect("a,fy=100", "fy goes together with fx");
  expect("a,fx=-5", "focal length");
  expect("a,plumb_bob=1 2 3 4", "k1 k2 p1 p2 k3");
  expect("a,equidistant=1 2 3 4 5", "k1 k2 k3 k4");
  expect("a,rate=-1", "images per second");
  expect("a,quality=0", "1 to 100");
  expect("a,depth=yes", "true or false");
  expect("a,labels=colour", "instance or semantic");
  expect("a,hfov=1", "the keys are parent");
  expect("a,,depth", "the keys are parent");
  expect("a,parent=x,optical=x", "one frame");
  expect(std::string("a\nb"), "needs a name");
}

TEST(CameraSpec, TopicsOfNames) {
  EXPECT_EQ(topic_from_name("front"), "front");
  EXPECT_EQ(topic_from_name("head camera/left"), "head_camera_left");
  EXPECT_EQ(topic_from_name("3d"), "camera_3d");
  EXPECT_EQ(topic_from_name(""), "camera");
}

TEST(CameraModel, CameraInfoNumbers) {
  CameraSpec spec;
  spec.fov = std::numbers::pi / 2;  // the half width is the focal length
  const Intrinsics k = intrinsics(spec);
  EXPECT_NEAR(k.fx, 320, 1e-9);
  EXPECT_NEAR(k.fy, 320, 1e-9);
  EXPECT_EQ(k.cx, 319.5);  // the centre of the top left pixel is (0, 0)
  EXPECT_EQ(k.cy, 239.5);
  const CalibrationNumbers plain = calibration({500, 501, 319.5, 239.5}, Lens::none, {1, 1, 1, 1, 1});
  EXPECT_EQ(plain.distortion_model, "plumb_bob");
  EXPECT_EQ(plain.d, std::vector<double>(5, 0.0));
  EXPECT_EQ(plain.k, (std::array<double, 9>{500, 0, 319.5, 0, 501, 239.5, 0, 0, 1}));
  EXPECT_EQ(plain.r, (std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(plain.p, (std::array<double, 12>{500, 0, 319.5, 0, 0, 501, 239.5, 0, 0, 0, 1, 0}));
  const CalibrationNumbers bent = calibration({1, 1, 0, 0}, Lens::plumb_bob, {.1, .2, .3, .4, .5});
  EXPECT_EQ(bent.d, (std::vector<double>{.1, .2, .3, .4, .5}));
  const CalibrationNumbers fish = calibration({1, 1, 0, 0}, Lens::equidistant, {.1, .2, .3, .4, 0});
  EXPECT_EQ(fish.distortion_model, "equidistant");
  EXPECT_EQ(fish.d, (std::vector<double>{.1, .2, .3, .4}));
}

TEST(CameraModel, OpticalFrameOfBodyFrame) {
  CameraSpec spec;
  spec.parent_frame = "base";
  spec.xyz = {1, 2, 3};
  // REP 103: z of the optical frame is forward (x), x is right (-y), y is down (-z).
  const Matrix34 matrix = parent_from_optical(spec);
  EXPECT_EQ(matrix, (Matrix34{0, 0, 1, 1, -1, 0, 0, 2, 0, -1, 0, 3}));
  const RigidTransform transform = rigid_transform(matrix);
  EXPECT_EQ(transform.translation, (std::array<double, 3>{1, 2, 3}));
  const std::array<double, 4> expected{-0.5, 0.5, -0.5, 0.5};
  for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(transform.rotation[i], expected[i], 1e-15);
  // The renderer's camera looks along -Z with +Y up: in the body frame -z is x and y is z.
  const Matrix34 camera = parent_from_camera(matrix);
  EXPECT_EQ((std::array<double, 3>{-camera[2], -camera[6], -camera[10]}), (std::array<double, 3>{1, 0, 0}));
  EXPECT_EQ((std::array<double, 3>{camera[1], camera[5], camera[9]}), (std::array<double, 3>{0, 0, 1}));
}

TEST(CameraModel, RotationsEqualUrdfdoms) {
  urdf::Rotation optical;
  optical.setFromQuaternion(-0.5, 0.5, -0.5, 0.5);
  size_t branches = 0;  // components that were greatest
  for (double roll = -3; roll <= 3; roll += 0.75) {
    for (double pitch = -1.5; pitch <= 1.5; pitch += 0.375) {
      for (double yaw = -3; yaw <= 3; yaw += 0.75) {
        CameraSpec spec;
        spec.parent_frame = "base";
        spec.rpy = {roll, pitch, yaw};
        const std::array<double, 4> q = rigid_transform(parent_from_optical(spec)).rotation;
        urdf::Rotation oracle;
        oracle.setFromRPY(roll, pitch, yaw);
        oracle = oracle * optical;
        const double dot = q[0] * oracle.x + q[1] * oracle.y + q[2] * oracle.z + q[3] * oracle.w;
        ASSERT_NEAR(std::abs(dot), 1, 1e-12) << roll << " " << pitch << " " << yaw;
        ASSERT_GE(q[3], 0);
        for (size_t i = 0; i < 4; ++i)
          if (std::abs(q[i]) > 0.71) branches |= size_t{1} << i;
      }
    }
  }
  EXPECT_EQ(branches, 15u) << "not every branch of the conversion was taken";
}

}  // namespace
}  // namespace fire3dv::ros2
