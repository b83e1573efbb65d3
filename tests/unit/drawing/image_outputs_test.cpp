// Test of camera intrinsics, output names, plane offsets, and plane files.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "renderer/passes/outputs/image_outputs.h"
#include "renderer/passes/view.h"
#include "renderer/sinks/frame_line.h"
#include "renderer/sinks/npy.h"

namespace fire3dv {
namespace {

using passes::Plane;

passes::Intrinsics calibrated() {
  passes::Intrinsics k;
  k.fx_px = 600;
  k.fy_px = 500;
  k.cx_px = 250;
  k.cy_px = 310;
  k.image_px = {640, 480};
  k.near_m = 0.1f;
  return k;
}

glm::vec2 pixel_of(const passes::View& view, glm::vec3 world, glm::vec2 size) {
  const glm::vec4 clip = view.clip_from_world * glm::vec4(world, 1);
  return (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * size - 0.5f;
}

TEST(Intrinsics, ProjectAsTheirFormulaSays) {
  const passes::Intrinsics k = calibrated();
  const glm::mat4 pose = passes::look_at_pose({1, 2, 3}, {-2, 0.5f, 0});
  const passes::View view = passes::make_view(k, pose);
  for (const glm::vec3 camera : {glm::vec3(0, 0, -1), glm::vec3(0.3f, -0.2f, -2), glm::vec3(-1, 1, -5)}) {
    const glm::vec3 world(pose * glm::vec4(camera, 1));
    const glm::vec2 pixel = pixel_of(view, world, k.image_px);
    EXPECT_NEAR(pixel.x, 600 * camera.x / -camera.z + 250, 1e-3);
    EXPECT_NEAR(pixel.y, 500 * -camera.y / -camera.z + 310, 1e-3);
    // The ray through that pixel passes through the point.
    const glm::vec2 ndc = (pixel + 0.5f) / glm::vec2(k.image_px) * 2.0f - 1.0f;
    const glm::vec3 ray =
        view.world_from_ndc_x * ndc.x + view.world_from_ndc_y * ndc.y + view.world_from_ndc_origin;
    EXPECT_LT(glm::distance(view.eye_world + ray * -camera.z, world), 1e-5f);
  }
  EXPECT_TRUE(view.off_centre);
}

TEST(Intrinsics, OfASceneCameraTakeTheSameImage) {
  scene::Camera camera;
  camera.near_m = 0.2f;
  const glm::mat4 pose = passes::look_at_pose({1, 2, 3}, {0, 0, 0});
  for (const float far_m : {0.0f, 50.0f}) {
    camera.far_m = far_m;
    const passes::View of_scene = passes::make_view(camera, pose, 640.0f / 480);
    const passes::View of_intrinsics = passes::make_view(passes::intrinsics_of(camera, {640, 480}), pose);
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) {
        EXPECT_NEAR(of_scene.clip_from_world[column][row], of_intrinsics.clip_from_world[column][row], 1e-6);
      }
    }
    EXPECT_LT(glm::distance(of_scene.world_from_ndc_x, of_intrinsics.world_from_ndc_x), 1e-6f);
    EXPECT_LT(glm::distance(of_scene.world_from_ndc_origin, of_intrinsics.world_from_ndc_origin), 1e-6f);
    const glm::vec2 a = passes::half_pixel_depth(of_scene, 480),
                    b = passes::half_pixel_depth(of_intrinsics, 480);
    EXPECT_NEAR(a.x, b.x, 1e-8);
    EXPECT_NEAR(a.y, b.y, 1e-8);
  }
}

// The pixel size is independent of the principal point.
TEST(Intrinsics, HalfAPixelDoesNotDependOnTheMiddle) {
  passes::Intrinsics middle = calibrated(), aside = calibrated();
  middle.cx_px = 319.5f, middle.cy_px = 239.5f;
  aside.cx_px = -500, aside.cy_px = 900;
  const glm::mat4 pose(1);
  EXPECT_NEAR(passes::half_pixel_depth(passes::make_view(middle, pose), 480).x,
              passes::half_pixel_depth(passes::make_view(aside, pose), 480).x, 1e-8);
}

TEST(Intrinsics, ThatNoImageCanBeTakenWithAreRefused) {
  EXPECT_TRUE(passes::check(calibrated()));
  const float nan = std::nanf("");
  const auto refuses = [](auto&& change, const char* names) {
    passes::Intrinsics k = calibrated();
    change(k);
    const Result<void> checked = passes::check(k);
    ASSERT_FALSE(checked) << names;
    EXPECT_NE(checked.error().message.find(names), std::string::npos) << checked.error().message;
  };
  refuses([](auto& k) { k.fx_px = 0; }, "fx");
  refuses([&](auto& k) { k.fy_px = nan; }, "fy");
  refuses([](auto& k) { k.cx_px = INFINITY; }, "cx");
  refuses([](auto& k) { k.near_m = 0; }, "near");
  refuses([](auto& k) { k.far_m = 0.05f; }, "far");
  refuses([](auto& k) { k.image_px.y = 0; }, "image");
}

TEST(ImageOutputs, AreNamedOnceEach) {
  const auto parsed = passes::parse_image_outputs("depth,boxes2d,semantic");
  ASSERT_TRUE(parsed.ok());
  EXPECT_FALSE(parsed->color_srgb8);
  EXPECT_TRUE((*parsed)[Plane::depth_f32] && (*parsed)[Plane::semantic_u32] && parsed->boxes2d);
  EXPECT_FALSE((*parsed)[Plane::instance_u32]);
  EXPECT_TRUE(passes::with_sources(*parsed)[Plane::instance_u32]);
  EXPECT_EQ(*passes::parse_image_outputs("color"), passes::ImageOutputs{});
  for (const char* bad : {"", "depth,", ",depth", "depth,depth", "Depth", "depth instance"}) {
    const auto refused = passes::parse_image_outputs(bad);
    EXPECT_FALSE(refused.ok()) << bad;
  }
  EXPECT_NE(passes::parse_image_outputs("colour").error().message.find("boxes3d"), std::string::npos);
}

TEST(ImageOutputs, PlanesLieOneBehindTheOther) {
  passes::ImageOutputs outputs;
  EXPECT_EQ(passes::bytes_of(passes::place_planes(outputs, 100, 100)), 0u);
  outputs.planes.fill(true);
  uint64_t end = 0;
  for (const passes::PlanePlace& place : passes::place_planes(outputs, 7, 5)) {
    EXPECT_GE(place.offset_bytes, end);
    EXPECT_EQ(place.offset_bytes % 64, 0u);
    EXPECT_EQ(place.size_bytes, 35u * passes::format_of(place.plane).pixel_bytes);
    end = place.offset_bytes + place.size_bytes;
  }
  EXPECT_EQ(passes::bytes_of(passes::place_planes(outputs, 7, 5)), end);
  const auto large = passes::place_planes(outputs, 1u << 16, 1u << 16);
  EXPECT_GT(passes::bytes_of(large), uint64_t{1} << 36) << "bytes are counted with 64 bits";
}

TEST(Planes, AreFilesThatNumPyOpens) {
  const sinks::FramePlane plane{"motion", "<f4", 2, std::vector<uint8_t>(2 * 3 * 8, 7)};
  const std::vector<uint8_t> file = sinks::encode_npy(plane, 3, 2);
  ASSERT_GT(file.size(), 128u);
  EXPECT_EQ(std::string(file.begin(), file.begin() + 8), std::string("\x93NUMPY\x01\x00", 8));
  const size_t header = file[8] + size_t{256} * file[9];
  EXPECT_EQ((10 + header) % 64, 0u);
  const std::string text(file.begin() + 10, file.begin() + 10 + static_cast<std::ptrdiff_t>(header));
  EXPECT_EQ(text.back(), '\n');
  EXPECT_EQ(text.substr(0, text.find('}') + 1),
            "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 2), }");
  EXPECT_EQ(std::vector<uint8_t>(file.begin() + 10 + static_cast<std::ptrdiff_t>(header), file.end()),
            plane.bytes);
  const sinks::FramePlane single{"depth", "<f4", 1, std::vector<uint8_t>(24)};
  const std::vector<uint8_t> flat = sinks::encode_npy(single, 3, 2);
  EXPECT_NE(std::string(flat.begin(), flat.end()).find("'shape': (2, 3), }"), std::string::npos);
}

TEST(Planes, AreListedWithTheirBoxes) {
  sinks::FrameImage image;
  image.width = 4, image.height = 3, image.frame_index = 9, image.camera = "eye \"1\"";
  image.planes.push_back({"depth", "<f4", 1, std::vector<uint8_t>(48)});
  image.boxes2d = std::vector<sinks::FrameBox2d>{{5, 2, 1, 0, 3, 2, 4}};
  sinks::FrameBox3d box{5, 2, {}};
  box.world_from_box[0] = 1.5f;
  box.world_from_box[7] = std::nanf("");
  image.boxes3d = std::vector<sinks::FrameBox3d>{box};
  const auto line = nlohmann::json::parse(sinks::frame_line({"", {"frame_000009.depth.npy"}}, image));
  EXPECT_FALSE(line.contains("file"));
  EXPECT_EQ(line["planes"]["depth"], "frame_000009.depth.npy");
  EXPECT_EQ(line["boxes2d"][0],
            nlohmann::json::parse(R"({"instance":5,"semantic":2,"box":[1,0,3,2],"pixels":4})"));
  EXPECT_EQ(line["boxes3d"][0]["world_from_box"][0], 1.5);
  EXPECT_TRUE(line["boxes3d"][0]["world_from_box"][7].is_null());
  image.boxes2d->clear();
  EXPECT_EQ(nlohmann::json::parse(sinks::frame_line({"a.png", {""}}, image))["boxes2d"].size(), 0u);
}

}  // namespace
}  // namespace fire3dv
