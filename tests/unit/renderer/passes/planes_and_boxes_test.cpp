// Test of camera intrinsics, the output table, plane offsets, and plane files.
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "protocol/wire/image_outputs.h"
#include "protocol/wire/messages.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/view/view.h"
#include "renderer/sinks/file_sink.h"
#include "renderer/sinks/output_text.h"

namespace fire3dv {
namespace {

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

// Both overloads of make_view() against glTF's formula of a perspective camera.
TEST(Intrinsics, SceneCameraMatchesGltf) {
  scene::Camera camera;
  camera.vertical_fov_rad = 0.8f;
  camera.near_m = 0.2f;
  const glm::mat4 pose = passes::look_at_pose({1, 2, 3}, {0, 0, 0});
  const float focal_px = 240 / std::tan(0.4f);
  const passes::Intrinsics intrinsics = passes::intrinsics_of(camera, {640, 480});
  EXPECT_NEAR(intrinsics.fx_px, focal_px, 1e-3f);
  EXPECT_NEAR(intrinsics.fy_px, focal_px, 1e-3f);
  EXPECT_EQ(intrinsics.cx_px, 319.5f);
  EXPECT_EQ(intrinsics.cy_px, 239.5f);
  for (const float far_m : {0.0f, 50.0f}) {
    camera.far_m = far_m;
    for (const passes::View& view : {passes::make_view(camera, pose, 640.0f / 480),
                                     passes::make_view(passes::intrinsics_of(camera, {640, 480}), pose)}) {
      for (const glm::vec3 at : {glm::vec3(0, 0, -1), glm::vec3(0.3f, -0.2f, -2), glm::vec3(-1, 1, -5)}) {
        const glm::vec2 pixel = pixel_of(view, glm::vec3(pose * glm::vec4(at, 1)), {640, 480});
        EXPECT_NEAR(pixel.x, 319.5f + focal_px * at.x / -at.z, 2e-3f);
        EXPECT_NEAR(pixel.y, 239.5f + focal_px * -at.y / -at.z, 2e-3f);
      }
      // Reversed depth: 1 at the near plane, 0 at the far one or at infinity.
      const auto depth_at = [&](float distance) {
        const glm::vec4 clip = view.clip_from_world * (pose * glm::vec4(0, 0, -distance, 1));
        return clip.z / clip.w;
      };
      EXPECT_NEAR(depth_at(0.2f), 1, 1e-5f);
      EXPECT_NEAR(depth_at(far_m > 0 ? far_m : 1e6f), 0, 1e-5f);
      EXPECT_FALSE(view.off_centre);
      // Half a pixel at 1 m, in metres.
      EXPECT_NEAR(passes::half_pixel_depth(view, 480).x, 0.5f / focal_px, 1e-7f);
    }
  }
}

// A camera of a scene with oblong pixels and a principal point off the centre, as its camera matrix says.
TEST(Intrinsics, SceneCameraMayBeOffCentre) {
  scene::Camera camera;
  camera.vertical_fov_rad = 2 * std::atan(0.5f);  // fy is the height
  camera.pixel_aspect = 0.5f;
  camera.principal_point = {-0.125f, 0.25f};
  const glm::uvec2 size(640, 480);
  const passes::Intrinsics k = passes::intrinsics_of(camera, size);
  EXPECT_NEAR(k.fx_px, 960, 1e-3f);
  EXPECT_NEAR(k.fy_px, 480, 1e-3f);
  EXPECT_NEAR(k.cx_px, 319.5f - 60, 1e-3f);
  EXPECT_NEAR(k.cy_px, 239.5f + 120, 1e-3f);
  const glm::mat4 pose = passes::look_at_pose({1, 2, 3}, {-2, 0.5f, 0});
  for (const float far_m : {0.0f, 50.0f}) {
    camera.far_m = far_m;
    const passes::View own = passes::make_view(camera, pose, 640.0f / 480),
                       same = passes::make_view(passes::intrinsics_of(camera, size), pose);
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 4; ++row)
        EXPECT_NEAR(own.clip_from_world[column][row], same.clip_from_world[column][row], 1e-5f);
    EXPECT_LT(glm::distance(own.world_from_ndc_x, same.world_from_ndc_x), 1e-6f);
    EXPECT_LT(glm::distance(own.world_from_ndc_y, same.world_from_ndc_y), 1e-6f);
    EXPECT_LT(glm::distance(own.world_from_ndc_origin, same.world_from_ndc_origin), 1e-6f);
    EXPECT_TRUE(own.off_centre);
  }
}

// The pixel size is independent of the principal point.
TEST(Intrinsics, HalfPixelIsIndependentOfCentre) {
  passes::Intrinsics middle = calibrated(), aside = calibrated();
  middle.cx_px = 319.5f, middle.cy_px = 239.5f;
  aside.cx_px = -500, aside.cy_px = 900;
  const glm::mat4 pose(1);
  EXPECT_NEAR(passes::half_pixel_depth(passes::make_view(middle, pose), 480).x,
              passes::half_pixel_depth(passes::make_view(aside, pose), 480).x, 1e-8);
}

TEST(Intrinsics, UnusableAreRefused) {
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

// The table of SPEC.md section 13, with command-line names and NumPy types.
TEST(ImageOutputTable, IsThatOfSpecification) {
  struct Row {
    uint32_t bit;
    const char *api_name, *cli_name;
    int format;
    uint32_t channels, element_bytes;
    const char* numpy_type;
    bool is_boxes, needs_ids;
  };
  constexpr Row kSpecification[] = {
      {0, "color_srgb8", "color", 1, 4, 4, "|u1", false, false},
      {1, "color_linear_f16", "linear", 2, 4, 8, "<f2", false, false},
      {2, "depth_f32", "depth", 3, 1, 4, "<f4", false, true},
      {3, "instance_u32", "instance", 4, 1, 4, "<u4", false, true},
      {4, "semantic_u32", "semantic", 4, 1, 4, "<u4", false, true},
      {5, "normal", "normal", 2, 4, 8, "<f2", false, true},
      {6, "motion", "motion", 5, 2, 8, "<f4", false, true},
      {7, "boxes2d", "boxes2d", 6, 0, 32, "", true, true},
      {8, "boxes3d", "boxes3d", 7, 0, 64, "", true, true},
      {9, "albedo_f16", "albedo", 2, 4, 8, "<f2", false, true},
      {10, "roughness_f32", "roughness", 3, 1, 4, "<f4", false, true},
      {11, "metallic_f32", "metallic", 3, 1, 4, "<f4", false, true},
      {12, "position_f32", "position", 8, 4, 16, "<f4", false, true},
      {13, "occlusion_u32", "occlusion", 4, 1, 4, "<u4", false, true},
      {14, "amodal", "amodal", 9, 0, 40, "", true, true},
  };
  ASSERT_EQ(wire::kImageOutputTable.size(), std::size(kSpecification));
  EXPECT_EQ(wire::kAllImageOutputs, 32767u);
  EXPECT_EQ(wire::kRequestableOutputs, 16383u);
  EXPECT_GE(wire::kProtocolMinor, 9) << "outputs 9 to 13 came with it";
  for (const Row& row : kSpecification) {
    const wire::ImageOutputInfo& info = wire::info_at(row.bit);
    SCOPED_TRACE(row.api_name);
    EXPECT_EQ(info.output, 1u << row.bit);
    EXPECT_EQ(info.api_name, row.api_name);
    EXPECT_EQ(info.cli_name, row.cli_name);
    EXPECT_EQ(static_cast<int>(info.format), row.format);
    EXPECT_EQ(info.channels, row.channels);
    EXPECT_EQ(info.element_bytes, row.element_bytes);
    EXPECT_EQ(info.numpy_type, row.numpy_type);
    EXPECT_EQ(info.is_boxes, row.is_boxes);
    EXPECT_EQ(info.needs_ids, row.needs_ids);
    EXPECT_EQ(&wire::info_of(info.output), &info);
    EXPECT_EQ(wire::find_image_output(row.api_name), &info);
    EXPECT_EQ(wire::find_image_output(row.cli_name), &info);
    // Planes and box lists of 3 elements, padded to multiples of 64 bytes.
    EXPECT_EQ(wire::pixel_bytes_of(3, 1, 1u << row.bit, 3), (3 * row.element_bytes + 63) / 64 * 64);
  }
  EXPECT_EQ(wire::pixel_bytes_of(7, 5, 511, 0), 192u + 320 + 192 + 192 + 192 + 320 + 320);
}

TEST(ImageOutputs, AreNamedOnceEach) {
  const auto parsed = wire::parse_image_outputs("depth,boxes2d,semantic");
  ASSERT_TRUE(parsed.ok());
  EXPECT_EQ(parsed->bits(), 4u | 128u | 16u);
  EXPECT_EQ(wire::with_sources(*parsed).bits(), 4u | 128u | 16u | 8u);
  EXPECT_EQ(wire::parse_image_outputs("depth_f32,boxes2d,semantic_u32")->bits(), parsed->bits());
  EXPECT_EQ(
      wire::parse_image_outputs("color,linear,depth,instance,semantic,normal,motion,boxes2d,boxes3d")->bits(),
      511u);
  EXPECT_EQ(*wire::parse_image_outputs("color"), wire::ImageOutputs{});
  for (const char* bad :
       {"", "depth,", ",depth", "depth,depth", "depth,depth_f32", "Depth", "depth instance"}) {
    const auto refused = wire::parse_image_outputs(bad);
    EXPECT_FALSE(refused.ok()) << bad;
  }
  EXPECT_EQ(
      wire::parse_image_outputs("colour").error().message,
      "there is no output \"colour\": there are color, linear, depth, instance, semantic, normal, motion, "
      "boxes2d, boxes3d, albedo, roughness, metallic, position, occlusion and amodal");
}

TEST(ImageOutputs, SayWhatTheyNeed) {
  using wire::ImageOutputs;
  EXPECT_TRUE(ImageOutputs(wire::kColorSrgb8).shaded());
  EXPECT_FALSE(ImageOutputs(wire::kColorSrgb8).has_planes());
  EXPECT_TRUE(ImageOutputs(wire::kColorLinearF16).shaded());
  EXPECT_TRUE(ImageOutputs(wire::kColorLinearF16).has_planes());
  EXPECT_FALSE(ImageOutputs(wire::kColorLinearF16).has_id_planes());
  for (const wire::ImageOutput output :
       {wire::kDepthF32, wire::kInstanceU32, wire::kSemanticU32, wire::kNormal, wire::kMotion,
        wire::kAlbedoF16, wire::kRoughnessF32, wire::kMetallicF32, wire::kPositionF32, wire::kOcclusionU32}) {
    EXPECT_TRUE(ImageOutputs(output).has_planes() && ImageOutputs(output).has_id_planes());
    EXPECT_FALSE(ImageOutputs(output).shaded() || ImageOutputs(output).has_boxes());
  }
  EXPECT_EQ(ImageOutputs::all_planes().bits(), 127u | 512 | 1024 | 2048 | 4096 | 8192);
  EXPECT_EQ(wire::with_sources(ImageOutputs(wire::kAmodal)).bits(), wire::kAmodal | wire::kInstanceU32);
  EXPECT_EQ(wire::with_sources(ImageOutputs(wire::kOcclusionU32)).bits(),
            wire::kOcclusionU32 | wire::kDepthF32);
}

TEST(ImageOutputs, PlanesLieOneBehindOther) {
  wire::ImageOutputs outputs;
  EXPECT_EQ(passes::bytes_of(passes::lay_out_planes(outputs, 100, 100)), 0u);
  outputs = wire::ImageOutputs::all_planes();
  uint64_t end = 0;
  for (const passes::PlaneRange& place : passes::lay_out_planes(outputs, 7, 5)) {
    EXPECT_GE(place.offset_bytes, end);
    EXPECT_EQ(place.offset_bytes % 64, 0u);
    EXPECT_EQ(place.size_bytes, 35u * wire::info_of(place.output).element_bytes);
    end = place.offset_bytes + place.size_bytes;
  }
  EXPECT_EQ(passes::bytes_of(passes::lay_out_planes(outputs, 7, 5)), end);
  EXPECT_EQ(end, 320u + 192 + 192 + 192 + 320 + 320 + 320 + 192 + 192 + 576 + 140)
      << "the last plane ends without padding";
  const auto large = passes::lay_out_planes(outputs, 1u << 16, 1u << 16);
  EXPECT_GT(passes::bytes_of(large), uint64_t{1} << 36) << "bytes are counted with 64 bits";
}

TEST(Planes, AreFilesThatNumPyOpens) {
  const sinks::FramePlane plane{wire::kMotion, std::vector<uint8_t>(2 * 3 * 8, 7)};
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
  const sinks::FramePlane single{wire::kDepthF32, std::vector<uint8_t>(24)};
  const std::vector<uint8_t> flat = sinks::encode_npy(single, 3, 2);
  EXPECT_NE(std::string(flat.begin(), flat.end()).find("'shape': (2, 3), }"), std::string::npos);
}

TEST(Planes, AreListedWithTheirBoxes) {
  sinks::FrameImage image;
  image.width = 4, image.height = 3, image.frame_index = 9, image.camera = "eye \"1\"";
  image.planes.push_back({wire::kDepthF32, std::vector<uint8_t>(48)});
  image.boxes2d = std::vector<wire::BoxRecord2d>{{5, 2, 1, 0, 3, 2, 4, 0}};
  wire::BoxRecord3d box{5, 2, {}, {}};
  box.world_from_box[0] = 1.5f;
  box.world_from_box[7] = std::nanf("");
  image.boxes3d = std::vector<wire::BoxRecord3d>{box};
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
