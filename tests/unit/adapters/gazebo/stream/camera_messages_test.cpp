// Cameras of Gazebo's worlds: topics and requests of their sensors.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "adapters/gazebo/stream/camera_messages.h"
#include "adapters/gazebo/stream/camera_spec.h"
#include "gazebo.pb.h"

namespace fire3dv::gazebo {
namespace {

// Models with one link "l" and one camera each.
class GazeboCameras : public testing::Test {
 protected:
  pb::Sensor& add(const std::string& model, const std::string& sensor, const std::string& topic = "") {
    pb::Model& added = *scene_.add_model();
    added.set_name(model);
    pb::Link& link = *added.add_link();
    link.set_name("l");
    pb::Sensor& camera = *link.add_sensor();
    camera.set_name(sensor);
    camera.set_type("camera");
    camera.set_topic(topic);
    camera.mutable_camera()->set_horizontal_fov(2 * std::atan(0.5));
    camera.mutable_camera()->mutable_image_size()->set_x(200);
    camera.mutable_camera()->mutable_image_size()->set_y(100);
    return camera;
  }
  std::vector<Result<CameraSpec>> specs() const {
    std::vector<std::string> warnings;
    std::vector<TopLevel> items = read_entities(scene_, warnings);
    std::vector<TopLevel*> all;
    for (TopLevel& item : items) all.push_back(&item);
    convert::SdfNames names;
    name_entities(all, names);
    std::vector<Result<CameraSpec>> found;
    for (const TopLevel& item : items)
      for (size_t i = 0; i < item.entities.size(); ++i)
        if (item.entities[i].sensor) found.push_back(camera_spec(item, i, "w"));
    return found;
  }
  pb::Scene scene_;
};

TEST_F(GazeboCameras, TopicNamesAreUnique) {
  add("m", "eye");
  add("m", "eye");
  scene_.mutable_model(0)->mutable_link(0)->add_visual()->set_name("eye");  // takes the name first
  add("my robot", "a@~//b");
  const auto found = specs();
  ASSERT_EQ(found.size(), 3u);
  for (const auto& spec : found) ASSERT_TRUE(spec) << spec.error().message;
  EXPECT_EQ(found[0]->images[0].name, "/world/w/model/m/link/l/sensor/eye_sensor/image");
  EXPECT_EQ(found[0]->info_topic, "/world/w/model/m/link/l/sensor/eye_sensor/camera_info");
  EXPECT_EQ(found[0]->frame_id, "m/l/eye sensor");
  EXPECT_EQ(found[1]->images[0].name, "/world/w/model/m_model/link/l_link/sensor/eye_sensor_2/image");
  EXPECT_EQ(found[1]->frame_id, "m/l/eye sensor 2");
  // Characters that no topic has are left out or replaced, as Gazebo does.
  EXPECT_EQ(found[2]->images[0].name, "/world/w/model/my_robot/link/l/sensor/a011b/image");
}

TEST_F(GazeboCameras, HaveTopicsOfTheirSensors) {
  add("a", "c", "eyes/left");
  add("b", "c", "/eyes//my right:=@~");
  add("c", "c", "/");
  add("d", "c", std::string(2000, 'x'));
  const auto found = specs();
  ASSERT_EQ(found.size(), 4u);
  ASSERT_TRUE(found[0] && found[1]);
  EXPECT_EQ(found[0]->images[0].name, "/eyes/left");
  EXPECT_EQ(found[0]->info_topic, "/eyes/camera_info");
  EXPECT_EQ(found[1]->images[0].name, "/eyes/my_right");
  EXPECT_FALSE(found[2]);
  EXPECT_FALSE(found[3]);
}

TEST_F(GazeboCameras, HaveOutputsOfTheirTypes) {
  add("a", "c");
  add("b", "c").set_type("depth_camera");
  add("c", "c").set_type("rgbd_camera");
  add("d", "c", "head").set_type("rgbd_camera");
  const auto found = specs();
  ASSERT_EQ(found.size(), 4u);
  for (const auto& spec : found) ASSERT_TRUE(spec) << spec.error().message;
  EXPECT_EQ(found[0]->request.outputs, uint32_t{FIRE3DV_IMAGE_COLOR_SRGB8});
  EXPECT_EQ(found[1]->request.outputs, uint32_t{FIRE3DV_IMAGE_DEPTH_F32});
  ASSERT_EQ(found[1]->images.size(), 1u);
  EXPECT_EQ(found[1]->images[0].name, "/world/w/model/b/link/l/sensor/c/depth_image");
  EXPECT_EQ(found[2]->request.outputs, uint32_t{FIRE3DV_IMAGE_COLOR_SRGB8 | FIRE3DV_IMAGE_DEPTH_F32});
  ASSERT_EQ(found[2]->images.size(), 2u);
  EXPECT_EQ(found[2]->images[0].name, "/world/w/model/c/link/l/sensor/c/image");
  EXPECT_EQ(found[2]->images[1].name, "/world/w/model/c/link/l/sensor/c/depth_image");
  EXPECT_EQ(found[2]->images[1].output, uint32_t{FIRE3DV_IMAGE_DEPTH_F32});
  EXPECT_EQ(found[3]->images[0].name, "/head/image");
  EXPECT_EQ(found[3]->images[1].name, "/head/depth_image");
  EXPECT_EQ(found[3]->info_topic, "/head/camera_info");
}

TEST_F(GazeboCameras, UnsupportedTypesAreRefused) {
  add("a", "c").set_type("thermal_camera");
  add("b", "c").set_type("segmentation_camera");
  add("c", "c").set_type("wide_angle_camera");
  const auto found = specs();
  ASSERT_EQ(found.size(), 3u);
  for (const auto& spec : found) ASSERT_FALSE(spec);
  EXPECT_EQ(found[0].error().message,
            "sensors of type \"thermal_camera\" are not rendered, only camera, depth_camera and rgbd_camera");
}

// Rows of the renderer may be longer than those of messages, which are tight.
TEST(GazeboCameraMessages, HaveTightRows) {
  const std::vector<uint8_t> colors = {1, 2, 3, 255, 4, 5, 6, 255, 0, 0, 0, 0, 7, 8, 9, 255, 10, 11, 12, 255};
  const std::vector<float> depths = {1, 2, 99, 3, INFINITY};
  const fire3dv_image_plane planes[] = {{FIRE3DV_IMAGE_COLOR_SRGB8, 2, 2, 12, colors.data()},
                                        {FIRE3DV_IMAGE_DEPTH_F32, 2, 2, 12, depths.data()}};
  fire3dv_image image{};
  image.sim_time_ns = -1;
  image.width = image.height = 2;
  image.plane_count = 2;
  image.planes = planes;
  const auto read = [&](uint32_t output) {
    const std::vector<std::byte> bytes = image_message(image, output, "f");
    pb::Image message;
    EXPECT_TRUE(message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())));
    EXPECT_EQ(message.header().stamp().sec(), -1);
    EXPECT_EQ(message.header().stamp().nsec(), 999'999'999);
    return message;
  };
  const pb::Image color = read(FIRE3DV_IMAGE_COLOR_SRGB8), depth = read(FIRE3DV_IMAGE_DEPTH_F32);
  EXPECT_EQ(color.step(), 6u);
  EXPECT_EQ(color.data(), std::string("\1\2\3\4\5\6\7\10\11\12\13\14"));
  EXPECT_EQ(depth.step(), 8u);
  EXPECT_EQ(depth.pixel_format_type(), 13);
  std::vector<float> sent(depth.data().size() / 4);
  std::memcpy(sent.data(), depth.data().data(), depth.data().size());
  EXPECT_EQ(sent, (std::vector<float>{1, 2, 3, INFINITY}));
  EXPECT_TRUE(image_message(image, FIRE3DV_IMAGE_NORMAL, "f").empty());
}

TEST_F(GazeboCameras, HaveProjectionOfTheirSensors) {
  pb::Sensor& eye = add("m", "eye");
  eye.set_update_rate(20);
  eye.mutable_camera()->set_near_clip(0.5);
  eye.mutable_camera()->set_far_clip(30);
  eye.mutable_camera()->mutable_distortion()->set_p1(0.25);
  eye.mutable_camera()->mutable_distortion()->set_k3(NAN);
  const auto found = specs();
  ASSERT_TRUE(found.size() == 1 && found[0]);
  const fire3dv_image_request& request = found[0]->request;
  EXPECT_EQ(request.width, 200u);
  EXPECT_EQ(request.height, 100u);
  EXPECT_FLOAT_EQ(request.fx, 200);
  EXPECT_FLOAT_EQ(request.fy, 200);
  EXPECT_EQ(request.cx, 99.5f);
  EXPECT_EQ(request.cy, 49.5f);
  EXPECT_EQ(request.near_m, 0.5f);
  EXPECT_EQ(request.far_m, 30);
  EXPECT_EQ(request.lens, FIRE3DV_LENS_PLUMB_BOB);
  EXPECT_EQ(request.lens_coefficients[2], 0.25f);
  EXPECT_EQ(request.lens_coefficients[4], 0);
  EXPECT_EQ(found[0]->period_ns, 50'000'000);
}

TEST_F(GazeboCameras, SizelessCamerasAreRefused) {
  add("a", "wide").mutable_camera()->mutable_image_size()->set_x(8193);
  add("b", "none").mutable_camera()->mutable_image_size()->set_y(NAN);
  add("c", "flat").mutable_camera()->set_horizontal_fov(0);
  add("d", "round").mutable_camera()->set_horizontal_fov(6);
  for (const auto& spec : specs()) EXPECT_FALSE(spec);
}

}  // namespace
}  // namespace fire3dv::gazebo
