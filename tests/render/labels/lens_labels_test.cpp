// Render test of labels through a lens: each pixel shows the surface that its ray hits, and occlusion knows
// what the previous image showed through that lens.
#include <gtest/gtest.h>

#include <cmath>

#include "renderer/passes/post/lens_pass.h"
#include "tests/render/labels/label_scenes.h"

namespace fire3dv::test {
namespace {

class LensLabels : public ValidationIsSilent, public ::testing::WithParamInterface<passes::LensModel> {};

passes::Lens lens_of(passes::LensModel model) {
  passes::Lens lens;
  lens.model = model;
  if (model == passes::LensModel::plumb_bob)
    lens.coefficients = {-0.25f, 0.03f, 0.002f, -0.001f, 0};
  else
    lens.coefficients = {-0.05f, 0.01f, 0, 0, 0};
  return lens;
}

// Planes of an image through a lens.
Taken take_through(RenderBench& bench, passes::LensPass& lens_pass, const state::PoseState& poses,
                   const passes::Intrinsics& pinhole, const glm::mat4& pose,
                   const passes::LensPass::Wanted& wanted, passes::CameraHistory& history) {
  bench.set_size({pinhole.image_px.x, pinhole.image_px.y});
  const passes::PreparedFrame prepared = bench.prepare({.outputs = passes::pinhole_outputs(wanted.outputs)});
  lens_pass.make_room(pinhole, wanted);
  gpu::Recorder& recorder = bench.frames().begin();
  bench.renderer().record(prepared, recorder, bench.frames().staging(), poses,
                          passes::make_view(pinhole, pose), &history);
  lens_pass.record(recorder, bench.frames().staging(),
                   {pinhole, nullptr, &bench.renderer().planes(), bench.renderer().plane_ranges()}, wanted);
  Taken taken;
  taken.places = lens_pass.places();
  gpu::ReadbackRing<int> readback(device());
  readback.record(recorder, nullptr, kLabelExtent, {&lens_pass.result(), lens_pass.result_bytes()}, 0);
  readback.submitted(bench.frames().submit());
  readback.drain([&](int, VkExtent2D, std::span<const uint8_t> bytes) {
    taken.planes.assign(bytes.begin(), bytes.end());
  });
  return taken;
}

TEST_P(LensLabels, AllPlanesShowTheSurfaceOfThePixel) {
  const scene::Scene scene = plate_and_wall();
  const std::vector<Face> faces = resting_faces(scene);
  const state::PoseState poses(scene);
  const passes::Lens lens = lens_of(GetParam());
  Eye before = eye_at({0, 0, 4}, {0, 0, 0}), now = eye_at({-1.2f, 0, 4}, {-0.2f, 0.2f, 0});
  for (Eye* const eye : {&before, &now}) eye->intrinsics.fx_px = eye->intrinsics.fy_px = 60;
  const Result<passes::Intrinsics> pinhole = passes::pinhole_behind(now.intrinsics, lens, 1024);
  ASSERT_TRUE(pinhole) << pinhole.error().message;
  wire::ImageOutputs outputs = wire::ImageOutputs::all_planes();
  outputs.remove(wire::kColorSrgb8);
  outputs.remove(wire::kColorLinearF16);
  RenderBench bench(scene, kLabelExtent, plain());
  passes::LensPass lens_pass(device());
  const passes::LensPass::Wanted wanted{now.intrinsics, lens, outputs};
  passes::CameraHistory history;
  take_through(bench, lens_pass, poses, *pinhole, glm::mat4(before.world_from_camera), wanted, history);
  const Taken taken =
      take_through(bench, lens_pass, poses, *pinhole, glm::mat4(now.world_from_camera), wanted, history);
  const auto depth = taken.plane<float>(wire::kDepthF32), roughness = taken.plane<float>(wire::kRoughnessF32);
  const auto instances = taken.plane<uint32_t>(wire::kInstanceU32),
             semantics = taken.plane<uint32_t>(wire::kSemanticU32),
             occlusion = taken.plane<uint32_t>(wire::kOcclusionU32);
  const auto motion = taken.plane<glm::vec2>(wire::kMotion);
  const auto position = taken.plane<glm::vec4>(wire::kPositionF32);
  const glm::dvec2 focal(now.intrinsics.fx_px, now.intrinsics.fy_px),
      principal(now.intrinsics.cx_px, now.intrinsics.cy_px), size(kLabelExtent.width, kLabelExtent.height);
  const glm::dmat4 camera_from_world = glm::inverse(before.world_from_camera);
  size_t counts[3] = {}, compared = 0;
  for (uint32_t y = 0; y < kLabelExtent.height; ++y) {
    for (uint32_t x = 0; x < kLabelExtent.width; ++x) {
      const size_t i = size_t{y} * kLabelExtent.width + x;
      const auto point = passes::undistort(lens, (glm::dvec2(x, y) - principal) / focal);
      if (!point) continue;
      const glm::dvec2 place = *point * focal + principal;
      const Hit hit = now.cast(faces, place);
      bool is_inside = true;
      for (const glm::dvec2 aside :
           {glm::dvec2(1, 1), glm::dvec2(-1, 1), glm::dvec2(1, -1), glm::dvec2(-1, -1)})
        is_inside &= now.cast(faces, place + aside).face == hit.face;
      if (!is_inside) continue;
      ++compared;
      ASSERT_EQ(instances[i], hit.instance) << "at " << x << ", " << y;
      ASSERT_EQ(semantics[i], hit.instance == 0 ? 0 : 9 + hit.instance);
      if (hit.instance == 0) {
        ASSERT_EQ(occlusion[i], 0u);
        continue;
      }
      ASSERT_NEAR(depth[i], hit.depth_m, 2e-4 * hit.depth_m) << "at " << x << ", " << y;
      ASSERT_LT(glm::distance(glm::dvec3(position[i]), hit.point_world), 0.05);  // of the nearest pixel
      ASSERT_EQ(roughness[i], hit.instance == kWall + 1 ? matte({}).roughness : 0.3125f);
      const glm::dvec3 local(camera_from_world * glm::dvec4(hit.point_world, 1));
      const glm::dvec2 ahead = glm::dvec2(local.x, -local.y) / -local.z;
      const glm::dvec2 last = passes::distort(lens, ahead) * focal + principal;
      ASSERT_LT(glm::distance(glm::dvec2(x, y) - last, glm::dvec2(motion[i])), 0.6)
          << "at " << x << ", " << y;
      const glm::dvec2 from_edge = glm::min(last + 0.5, size - 0.5 - last);
      const double inside_px = std::min(from_edge.x, from_edge.y);
      const bool is_outside = inside_px < 0 || glm::length(ahead) > passes::largest_radius(lens);
      if (std::abs(inside_px) < 1) continue;
      const glm::dvec2 place_before = ahead * focal + principal;
      const Hit earlier = before.cast(faces, place_before);
      bool is_certain = true;
      for (const glm::dvec2 aside :
           {glm::dvec2(1.5, 1.5), glm::dvec2(-1.5, 1.5), glm::dvec2(1.5, -1.5), glm::dvec2(-1.5, -1.5)})
        is_certain &= before.cast(faces, place_before + aside).instance == earlier.instance;
      if (!is_outside && !is_certain) continue;
      const uint32_t want = is_outside ? 2 : earlier.instance != hit.instance ? 1 : 0;
      ASSERT_EQ(occlusion[i], want) << "at " << x << ", " << y;
      ++counts[want];
    }
  }
  EXPECT_GT(compared, 4000u);
  EXPECT_GT(counts[0], 3000u);
  EXPECT_GT(counts[1], 10u);
  EXPECT_GT(counts[2], 100u);
}
INSTANTIATE_TEST_SUITE_P(Models, LensLabels,
                         ::testing::Values(passes::LensModel::plumb_bob, passes::LensModel::fisheye));

}  // namespace
}  // namespace fire3dv::test
