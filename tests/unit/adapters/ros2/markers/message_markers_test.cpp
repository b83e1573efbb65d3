// Markers of ROS 2 messages, against numbers computed by hand.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "adapters/ros2/markers/message_markers.h"

namespace fire3dv::ros2 {
namespace {

// Message whose text and sequences the test owns.
struct TestMarker {
  MarkerMessage message{};
  std::string frame = "/base", ns = "forces";
  std::vector<geometry_msgs_msg_dds__Point_> points;
  std::vector<std_msgs_msg_dds__ColorRGBA_> colors;

  explicit TestMarker(int32_t type) {
    message.type = type;
    message.id = 7;
    message.pose.orientation.w = 1;
    message.scale = {0.1, 0.2, 0.3};
    message.color = {1, 0.5f, 0, 1};
  }
  Result<MarkerUpdate> update() {
    message.header.frame_id = frame.data();
    message.ns = ns.data();
    message.points._buffer = points.data();
    message.points._length = static_cast<uint32_t>(points.size());
    message.colors._buffer = colors.data();
    message.colors._length = static_cast<uint32_t>(colors.size());
    return update_of("viz", message);
  }
};

TEST(Ros2Markers, SolidHasExtentAndColour) {
  TestMarker cube(1);
  cube.message.pose.position = {1, 2, 3};
  cube.message.lifetime = {2, 5};
  const Result<MarkerUpdate> update = cube.update();
  ASSERT_TRUE(update) << update.error().message;
  const ShownMarker& marker = update->marker;
  EXPECT_EQ(marker.name, "viz/forces/7");
  EXPECT_EQ(marker.frame, "base");
  EXPECT_EQ(marker.kind, FIRE3DV_MARKER_BOXES);
  EXPECT_EQ(marker.frame_from_marker.translation, (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(marker.positions, (std::vector<float>{0, 0, 0}));
  EXPECT_EQ(marker.sizes, (std::vector<float>{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(marker.colors, (std::vector<uint8_t>{255, 128, 0, 255}));
  EXPECT_EQ(marker.lifetime_ns, 2'000'000'005u);
}

TEST(Ros2Markers, TextHeightIsCapitals) {
  TestMarker label(9);
  std::string text = "pump\n2 bar";
  label.message.text = text.data();
  const Result<MarkerUpdate> update = label.update();
  ASSERT_TRUE(update) << update.error().message;
  EXPECT_EQ(update->marker.kind, FIRE3DV_MARKER_TEXTS);
  EXPECT_EQ(update->marker.texts, std::vector<std::string>{text});
  EXPECT_EQ(update->marker.positions, (std::vector<float>{0, 0, 0}));
  EXPECT_NEAR(update->marker.width_m * 1493 / 2048, 0.3, 1e-4)
      << "DejaVu Sans: capitals have 1493 of 2048 units";
  EXPECT_TRUE(update->marker.sizes.empty());
  label.message.text = nullptr;
  EXPECT_EQ(label.update()->marker.texts, std::vector<std::string>{""});
}

TEST(Ros2Markers, ListsHaveColours) {
  TestMarker lines(5);
  lines.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 2, 0}};
  lines.colors.assign(4, {0, 0, 1, 0.5f});
  const Result<MarkerUpdate> update = lines.update();
  ASSERT_TRUE(update);
  EXPECT_EQ(update->marker.kind, FIRE3DV_MARKER_LINES);
  EXPECT_EQ(update->marker.width_m, 0.1f);
  EXPECT_EQ(update->marker.positions.size(), 12u);
  EXPECT_EQ(update->marker.colors.size(), 16u);
  EXPECT_EQ(update->marker.colors[3], 128);
  lines.points.pop_back();
  EXPECT_FALSE(lines.update());
}

// As in rviz: scale multiplies the points, and colours are of vertices or of triangles.
TEST(Ros2Markers, TrianglesHaveFaceColours) {
  TestMarker triangles(11);
  triangles.message.scale = {2, 3, 4};
  triangles.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {0, 0, -1}};
  triangles.colors = {{1, 0, 0, 1}, {0, 1, 0, 1}};
  Result<MarkerUpdate> update = triangles.update();
  ASSERT_TRUE(update) << update.error().message;
  EXPECT_EQ(update->marker.kind, FIRE3DV_MARKER_TRIANGLES);
  EXPECT_EQ(update->marker.positions,
            (std::vector<float>{0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 4, 2, 3, 4, 0, 0, -4}));
  EXPECT_EQ(update->marker.colors,
            (std::vector<uint8_t>{255, 0,   0, 255, 255, 0,   0, 255, 255, 0,   0, 255,
                                  0,   255, 0, 255, 0,   255, 0, 255, 0,   255, 0, 255}));
  triangles.colors.assign(6, {0, 0, 1, 1});
  EXPECT_EQ(triangles.update()->marker.colors.size(), 24u);
  triangles.colors.assign(3, {0, 0, 1, 1});  // neither: the colour of the message
  EXPECT_EQ(triangles.update()->marker.colors, (std::vector<uint8_t>{255, 128, 0, 255}));
  triangles.message.scale.y = 0;
  EXPECT_FALSE(triangles.update());
  triangles.message.scale.y = 1e300;
  EXPECT_FALSE(triangles.update());
}

TEST(Ros2Markers, BothArrowFormsAreRead) {
  TestMarker arrow(0);
  arrow.message.scale = {2, 0.1, 0.2};
  Result<MarkerUpdate> update = arrow.update();
  ASSERT_TRUE(update);
  EXPECT_EQ(update->marker.positions, (std::vector<float>{0, 0, 0, 2, 0, 0}));
  EXPECT_EQ(update->marker.width_m, 0.1f);
  arrow.points = {{1, 1, 1}, {1, 1, 5}};
  update = arrow.update();
  ASSERT_TRUE(update);
  EXPECT_EQ(update->marker.positions, (std::vector<float>{1, 1, 1, 1, 1, 5}));
  EXPECT_EQ(update->marker.width_m, 2.0f);
  arrow.points.pop_back();
  EXPECT_FALSE(arrow.update());
}

TEST(Ros2Markers, ActionsClear) {
  TestMarker any(1);
  any.message.action = 2;
  EXPECT_EQ(any.update()->action, MarkerAction::clear);
  any.message.action = 3;
  EXPECT_EQ(any.update()->action, MarkerAction::clear_all);
  any.message.action = 9;
  EXPECT_FALSE(any.update());
}

TEST(Ros2Markers, DamagedMessagesAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  TestMarker cube(1);
  cube.message.pose.orientation = {0, 0, 0, 0};  // as rviz: no rotation
  ASSERT_TRUE(cube.update());
  EXPECT_EQ(cube.update()->marker.frame_from_marker.rotation, (std::array<double, 4>{0, 0, 0, 1}));
  cube.message.pose.orientation.x = nan;
  EXPECT_FALSE(cube.update());
  cube = TestMarker(1);
  cube.message.scale.y = -1;
  EXPECT_FALSE(cube.update());
  cube = TestMarker(8);
  cube.points = {{0, nan, 0}};
  EXPECT_FALSE(cube.update());
  cube = TestMarker(10);
  EXPECT_NE(cube.update().error().message.find("meshes"), std::string::npos);
  cube = TestMarker(99);
  EXPECT_FALSE(cube.update());
  cube = TestMarker(1);
  cube.ns.assign(5000, 'x');
  EXPECT_FALSE(cube.update());
}

// x, y, z as float32 and rgb in 16 bytes.
struct TestCloud {
  PointCloudMessage message{};
  std::string names[4] = {"x", "y", "z", "rgb"};
  std::vector<sensor_msgs_msg_dds__PointField_> fields;
  std::vector<uint8_t> data;

  TestCloud(uint32_t width, uint32_t height) : data(16 * width * height) {
    for (uint32_t i = 0; i < 4; ++i) fields.push_back({names[i].data(), 4 * i, 7, 1});
    message.width = width;
    message.height = height;
    message.point_step = 16;
    message.row_step = 16 * width;
  }
  void set(size_t index, float x, float y, float z, uint32_t rgb) {
    std::memcpy(&data[16 * index], &x, 4);
    std::memcpy(&data[16 * index + 4], &y, 4);
    std::memcpy(&data[16 * index + 8], &z, 4);
    std::memcpy(&data[16 * index + 12], &rgb, 4);
  }
  Result<ShownMarker> marker() {
    for (size_t i = 0; i < fields.size(); ++i) fields[i].name = names[i].data();
    message.fields._buffer = fields.data();
    message.fields._length = static_cast<uint32_t>(fields.size());
    message.data._buffer = data.data();
    message.data._length = static_cast<uint32_t>(data.size());
    return marker_of("lidar", message);
  }
};

TEST(Ros2Markers, CloudsKeepFinitePoints) {
  TestCloud cloud(2, 2);
  cloud.set(0, 1, 2, 3, 0xff8000);
  cloud.set(1, NAN, 0, 0, 0);
  cloud.set(2, 4, 5, 6, 0x0000ff);
  cloud.set(3, INFINITY, 0, 0, 0);
  const Result<ShownMarker> marker = cloud.marker();
  ASSERT_TRUE(marker) << marker.error().message;
  EXPECT_EQ(marker->positions, (std::vector<float>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(marker->colors, (std::vector<uint8_t>{255, 128, 0, 255, 0, 0, 255, 255}));
}

TEST(Ros2Markers, ShortCloudsAreRefused) {
  TestCloud cloud(2, 2);
  cloud.data.resize(63);
  EXPECT_FALSE(cloud.marker());
  cloud = TestCloud(2, 2);
  cloud.message.row_step = 8;
  EXPECT_FALSE(cloud.marker());
  cloud = TestCloud(2, 2);
  cloud.fields[2].offset = 13;  // ends beyond the point
  EXPECT_FALSE(cloud.marker());
  cloud = TestCloud(2, 2);
  cloud.fields[2].offset = 0xffffffff;
  EXPECT_FALSE(cloud.marker());
  cloud = TestCloud(1, 1);
  cloud.message.width = cloud.message.height = 0x10000;
  EXPECT_FALSE(cloud.marker());
  cloud = TestCloud(0, 0);
  EXPECT_TRUE(cloud.marker());
}

// The loop over 2^32 - 1 rows takes seconds.
template <typename Convert>
void expect_empty_at_once(Convert&& convert) {
  const auto begin = std::chrono::steady_clock::now();
  const Result<ShownMarker> marker = convert();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(500));
  ASSERT_TRUE(marker) << marker.error().message;
  EXPECT_TRUE(marker->positions.empty());
  EXPECT_EQ(marker->colors.size(), 4u);
}

TEST(Ros2Markers, EmptyCloudsReturnAtOnce) {
  TestCloud cloud(0, 0);
  cloud.message.height = 0xffffffff;
  expect_empty_at_once([&] { return cloud.marker(); });
  cloud.message.width = 0xffffffff;
  cloud.message.height = 0;
  expect_empty_at_once([&] { return cloud.marker(); });
}

TEST(Ros2Markers, EmptyMapsReturnAtOnce) {
  MapMessage map{};
  map.info.resolution = 0.5f;
  map.info.origin.orientation.w = 1;
  map.info.height = 0xffffffff;
  expect_empty_at_once([&] { return marker_of("map", map); });
  map.info.width = 0xffffffff;
  map.info.height = 0;
  expect_empty_at_once([&] { return marker_of("map", map); });
}

TEST(Ros2Markers, MapsAreRunsOfCells) {
  MapMessage map{};
  std::vector<uint8_t> cells = {100, 100, 0, 255};  // occupied, occupied, free, unknown
  map.info.resolution = 0.5f;
  map.info.width = 4;
  map.info.height = 1;
  map.info.origin.orientation.w = 1;
  map.data._buffer = cells.data();
  map.data._length = 4;
  const Result<ShownMarker> marker = marker_of("map", map);
  ASSERT_TRUE(marker) << marker.error().message;
  ASSERT_EQ(marker->positions.size(), 3 * 12u);  // two rectangles
  EXPECT_EQ(marker->positions[3], 1.0f);         // two cells of 0.5 m
  EXPECT_EQ(marker->positions[18], 1.0f);
  EXPECT_EQ(marker->positions[21], 1.5f);
  EXPECT_EQ(marker->colors[0], 30);
  EXPECT_EQ(marker->colors[24], 230);
  map.info.width = 5;
  EXPECT_FALSE(marker_of("map", map));
  map.info.width = 4;
  map.info.resolution = 0;
  EXPECT_FALSE(marker_of("map", map));
}

TEST(Ros2Markers, PathsAreOfOneFrame) {
  PathMessage path{};
  std::string map_name = "map", odom = "odom";
  std::vector<geometry_msgs_msg_dds__PoseStamped_> poses(3);
  for (size_t i = 0; i < poses.size(); ++i) {
    poses[i].header.frame_id = map_name.data();
    poses[i].pose.position.x = static_cast<double>(i);
  }
  path.header.frame_id = map_name.data();
  path.poses._buffer = poses.data();
  path.poses._length = 3;
  const Result<ShownMarker> marker = marker_of("plan", path);
  ASSERT_TRUE(marker);
  EXPECT_EQ(marker->positions, (std::vector<float>{0, 0, 0, 1, 0, 0, 2, 0, 0}));
  poses[1].header.frame_id = odom.data();
  EXPECT_FALSE(marker_of("plan", path));
  path.poses._length = 1;
  EXPECT_TRUE(marker_of("plan", path)->positions.empty());
}

}  // namespace
}  // namespace fire3dv::ros2
