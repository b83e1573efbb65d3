// <sensor> tags of robot descriptions: Gazebo's and its classic plug-ins' spelling, bad values, hostile XML.
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "adapters/ros2/images/camera_model.h"
#include "adapters/ros2/images/sensor_tags.h"

namespace fire3dv::ros2 {
namespace {

std::string robot(const std::string& sensors, const std::string& link = "eye") {
  return "<robot name='r'><link name='base'/><link name='eye'/><link name='eye_optical'/><gazebo "
         "reference='" +
         link + "'>" + sensors + "</gazebo></robot>";
}

SensorCameras read(const std::string& urdf) {
  Result<SensorCameras> cameras = read_sensor_cameras(urdf);
  EXPECT_TRUE(cameras) << (cameras ? "" : cameras.error().message);
  return cameras ? std::move(*cameras) : SensorCameras{};
}

std::string warning(const std::string& sensors, const std::string& link = "eye") {
  const SensorCameras cameras = read(robot(sensors, link));
  EXPECT_EQ(cameras.warnings.size(), 1u) << sensors;
  return cameras.warnings.empty() ? "" : cameras.warnings.front();
}

TEST(SensorTags, Gazebo) {
  const SensorCameras found = read(robot(R"(
    <sensor name="front" type="rgbd_camera">
      <pose>0.1 0 0.2 0 0.5 0</pose>
      <update_rate> 15 </update_rate>
      <topic>front/image_raw</topic>
      <gz_frame_id>eye</gz_frame_id>
      <camera>
        <optical_frame_id>eye_optical</optical_frame_id>
        <horizontal_fov>1.5707963267948966</horizontal_fov>
        <image><width>200</width><height>100</height><format>R8G8B8</format></image>
        <clip><near>0.3</near><far>8</far></clip>
        <distortion>
          <k1>0.1</k1><k2>0.2</k2><k3>0.3</k3><p1>0.4</p1><p2>0.5</p2><center>0.5 0.5</center>
        </distortion>
      </camera>
    </sensor>
    <sensor name="laser" type="gpu_lidar"><topic>scan</topic></sensor>)"));
  EXPECT_TRUE(found.warnings.empty()) << found.warnings.front();
  ASSERT_EQ(found.cameras.size(), 1u);
  const CameraSpec& camera = found.cameras.front();
  EXPECT_EQ(camera.name, "front");
  EXPECT_EQ(camera.topic, "front");
  EXPECT_EQ(camera.parent_frame, "eye");
  EXPECT_EQ(camera.optical_frame, "eye_optical");
  EXPECT_FALSE(camera.publishes_frame) << "a link of the robot is published by robot_state_publisher";
  EXPECT_EQ(camera.xyz, (std::array<double, 3>{0.1, 0, 0.2}));
  EXPECT_EQ(camera.rpy, (std::array<double, 3>{0, 0.5, 0}));
  EXPECT_EQ(camera.rate_hz, 15);
  EXPECT_EQ(camera.width, 200u);
  EXPECT_EQ(camera.height, 100u);
  EXPECT_NEAR(intrinsics(camera).fx, 100, 1e-9);
  EXPECT_EQ(camera.near_m, 0.3);
  EXPECT_EQ(camera.far_m, 8);
  EXPECT_TRUE(camera.depth);
  EXPECT_EQ(camera.lens, Lens::plumb_bob);
  EXPECT_EQ(camera.lens_coefficients, (std::array<double, 5>{0.1, 0.2, 0.4, 0.5, 0.3})) << "k1 k2 p1 p2 k3";
}

TEST(SensorTags, DefaultsAreGazebos) {
  const SensorCameras found = read(robot("<sensor name='a' type='camera'/>"));
  ASSERT_EQ(found.cameras.size(), 1u);
  const CameraSpec& camera = found.cameras.front();
  EXPECT_EQ(camera.width, 320u);
  EXPECT_EQ(camera.height, 240u);
  EXPECT_EQ(camera.fov, 1.047);
  EXPECT_EQ(camera.near_m, 0.1);
  EXPECT_EQ(camera.far_m, 100);
  EXPECT_EQ(camera.rate_hz, 0);
  EXPECT_EQ(camera.topic, "a");
  EXPECT_EQ(camera.optical_frame, "a_optical_frame");
  EXPECT_TRUE(camera.publishes_frame);
}

TEST(SensorTags, ClassicPlugin) {
  const SensorCameras found = read(robot(R"(
    <sensor type="depth" name="d">
      <camera name="head"><horizontal_fov>1</horizontal_fov></camera>
      <plugin name="c" filename="libgazebo_ros_camera.so">
        <ros><namespace>/robot</namespace></ros><camera_name>depth_cam</camera_name>
        <frame_name>d_optical</frame_name>
      </plugin>
    </sensor>
    <sensor type="camera" name="e">
      <plugin name="c" filename="libgazebo_ros_camera.so">
        <cameraName>rrbot/camera1</cameraName><frameName>eye</frameName>
      </plugin>
    </sensor>)"));
  EXPECT_TRUE(found.warnings.empty()) << found.warnings.front();
  ASSERT_EQ(found.cameras.size(), 2u);
  EXPECT_EQ(found.cameras[0].topic, "/robot/depth_cam");
  EXPECT_EQ(found.cameras[0].optical_frame, "d_optical");
  EXPECT_TRUE(found.cameras[0].publishes_frame);
  EXPECT_TRUE(found.cameras[0].depth);
  EXPECT_EQ(found.cameras[1].topic, "rrbot/camera1");
  EXPECT_EQ(found.cameras[1].optical_frame, "e_optical_frame") << "the sensor's link is a body frame";
}

TEST(SensorTags, NamesAndTopicsAreUnique) {
  const SensorCameras found = read(
      "<robot name='r'><link name='a'/><link name='b'/>"
      "<gazebo reference='a'><sensor name='cam' type='camera'><topic>image</topic></sensor></gazebo>"
      "<gazebo reference='b'><sensor name='cam' type='camera'><topic>image</topic></sensor>"
      "<sensor name='cam' type='camera'/></gazebo></robot>");
  ASSERT_EQ(found.cameras.size(), 2u);
  EXPECT_EQ(found.cameras[0].name, "cam");
  EXPECT_EQ(found.cameras[1].name, "b_cam");
  EXPECT_NE(found.cameras[0].topic, found.cameras[1].topic);
  ASSERT_EQ(found.warnings.size(), 2u);
  EXPECT_NE(found.warnings[0].find("another camera's"), std::string::npos);
  EXPECT_NE(found.warnings[1].find("another sensor has that name"), std::string::npos);
}

TEST(SensorTags, BadValuesWarn) {
  const auto expect = [](const std::string& text, std::string_view part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  const auto camera = [](const std::string& inside) {
    return "<sensor name='a' type='camera'>" + inside + "</sensor>";
  };
  expect(warning(camera("<pose>1 2 3</pose>")), "six numbers");
  expect(warning(camera("<update_rate>often</update_rate>")), "<update_rate> \"often\"");
  expect(warning(camera("<camera><horizontal_fov>4</horizontal_fov></camera>")), "1.047");
  expect(warning(camera("<camera><horizontal_fov>nan</horizontal_fov></camera>")), "\"nan\"");
  expect(warning(camera("<camera><image><width>1e9</width></image></camera>")), "<width>");
  expect(warning(camera("<camera><image><width>-5</width></image></camera>")), "<width>");
  expect(warning(camera("<camera><clip><near>5</near><far>2</far></clip></camera>")), "<clip>");
  expect(warning(camera("<topic>a b</topic>")), "not a topic name");
  expect(warning("<sensor type='camera'/>"), "no name");
  expect(warning("<sensor name='t' type='thermal'><camera/></sensor>"), "\"thermal\"");
  expect(warning("<sensor name='t'><camera/></sensor>"), "not a camera that is published");
  expect(warning(camera(""), "nowhere"), "no such link");
  // Control characters of a file do not reach the terminal.
  EXPECT_EQ(warning(camera("<topic>a\x1b[2J</topic>")).find('\x1b'), std::string::npos);
}

TEST(SensorTags, HostileXml) {
  EXPECT_FALSE(read_sensor_cameras(""));
  EXPECT_FALSE(read_sensor_cameras("<robot>"));
  EXPECT_FALSE(read_sensor_cameras("<sdf/>"));
  EXPECT_FALSE(read_sensor_cameras(std::string("\0\0\0", 3)));
  std::string deep = "<robot name='r'>";
  for (int i = 0; i < 200'000; ++i) deep += "<gazebo>";
  EXPECT_FALSE(read_sensor_cameras(deep));
  std::string many;
  for (int i = 0; i < 5000; ++i) many += "<sensor name='s" + std::to_string(i) + "' type='camera'/>";
  const SensorCameras cameras = read(robot(many));
  EXPECT_EQ(cameras.cameras.size(), kMaxCameras);
  EXPECT_LE(cameras.warnings.size(), 20u);
  // Entities are not expanded: neither files nor powers of text.
  const SensorCameras entity = read("<!DOCTYPE robot [<!ENTITY x SYSTEM 'file:///etc/passwd'>]>" +
                                    robot("<sensor name='&x;' type='camera'><topic>&x;</topic></sensor>"));
  ASSERT_EQ(entity.cameras.size(), 1u);
  EXPECT_EQ(entity.cameras.front().name, "&x;");
  EXPECT_EQ(entity.cameras.front().topic, "_x_");
  const std::string long_name(100'000, 'n');
  const SensorCameras longest = read(robot("<sensor name='" + long_name + "' type='camera'/>"));
  ASSERT_EQ(longest.cameras.size(), 1u);
  EXPECT_LE(longest.cameras.front().name.size(), 100u);
  // Every prefix of a good file is read or refused.
  const std::string good =
      robot("<sensor name='a' type='camera'><camera><clip><near>1</near></clip></camera></sensor>");
  for (size_t size = 0; size < good.size(); ++size) EXPECT_FALSE(read_sensor_cameras(good.substr(0, size)));
}

}  // namespace
}  // namespace fire3dv::ros2
