// Render test of labels of one image: material and position against rays, silhouettes of objects alone, and
// labels of blended surfaces.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/packing.hpp>

#include "renderer/capture/amodal.h"
#include "renderer/passes/outputs/silhouettes.h"
#include "tests/render/labels/label_scenes.h"

namespace fire3dv::test {
namespace {

class Labels : public ValidationIsSilent {};

TEST_F(Labels, MaterialAndPosition) {
  const scene::Scene scene = plate_and_wall();
  const Eye eye = eye_at({0.3f, 0.7f, 4}, {0, 0, 0});
  const std::vector<Face> faces = resting_faces(scene);
  const wire::ImageOutputs outputs(wire::kAlbedoF16 | wire::kRoughnessF32 | wire::kMetallicF32 |
                                   wire::kPositionF32);
  for (const uint32_t samples : {1u, 4u}) {
    RenderBench bench(scene, kLabelExtent, plain(samples));
    const Taken taken = bench.take(state::PoseState(scene), view_through(eye), outputs);
    const auto albedo = taken.plane<uint64_t>(wire::kAlbedoF16);
    const auto roughness = taken.plane<float>(wire::kRoughnessF32),
               metallic = taken.plane<float>(wire::kMetallicF32);
    const auto position = taken.plane<glm::vec4>(wire::kPositionF32);
    size_t compared = 0;
    for (uint32_t y = 0; y < kLabelExtent.height; ++y) {
      for (uint32_t x = 0; x < kLabelExtent.width; ++x) {
        const size_t i = size_t{y} * kLabelExtent.width + x;
        const auto hit = eye.cast_surely(faces, {x, y});
        bool is_inside = hit.has_value();
        for (const glm::dvec2 aside :
             {glm::dvec2(1, 1), glm::dvec2(-1, 1), glm::dvec2(1, -1), glm::dvec2(-1, -1)})
          is_inside = is_inside && eye.cast(faces, glm::dvec2(x, y) + 0.6 * aside).face == hit->face;
        if (!is_inside) continue;
        ++compared;
        if (hit->instance == 0) {
          ASSERT_EQ(albedo[i], 0u);
          ASSERT_EQ(position[i], glm::vec4(0));
          ASSERT_EQ(roughness[i] + metallic[i], 0);
          continue;
        }
        const bool is_steel = hit->instance != kWall + 1;
        const glm::vec4 color = glm::unpackHalf4x16(albedo[i]);
        ASSERT_LT(glm::distance(color,
                                is_steel ? glm::vec4(0.6f, 0.5f, 0.4f, 1) : glm::vec4(0.25f, 0.5f, 0.75f, 1)),
                  1e-3f);
        ASSERT_EQ(metallic[i], is_steel ? 0.75f : matte({}).metallic);
        ASSERT_EQ(roughness[i], is_steel ? 0.3125f : matte({}).roughness);
        ASSERT_LT(glm::distance(glm::dvec3(position[i]), hit->point_world), 1e-4) << "at " << x << ", " << y;
        ASSERT_EQ(position[i].w, 1);
      }
    }
    EXPECT_GT(compared, size_t{kLabelExtent.width} * kLabelExtent.height / 2);
  }
}

sinks::Amodal silhouettes_of(const Taken& taken, const scene::Scene& scene) {
  std::vector<capture::Silhouetted> slots;
  for (const uint32_t node : passes::nodes_with_silhouettes(scene))
    slots.push_back({node + 1, scene.nodes[node].semantic});
  const auto bits = taken.plane<uint8_t>(wire::kAmodal), instances = taken.plane<uint8_t>(wire::kInstanceU32);
  return capture::read_silhouettes(bits, instances, kLabelExtent.width, kLabelExtent.height, slots);
}

bool has_pixel(const sinks::Amodal& amodal, size_t record, uint32_t x, uint32_t y) {
  constexpr size_t kRow = (kLabelExtent.width + 7) / 8;
  return (amodal.masks[(record * kLabelExtent.height + y) * kRow + x / 8] & (0x80 >> (x % 8))) != 0;
}

// Each object alone, by rays; counts and boxes follow from the masks.
TEST_F(Labels, SilhouettesAreThoseOfObjectsAlone) {
  const scene::Scene scene = plate_and_wall();
  const Eye eye = eye_at({0.3f, 0.4f, 4}, {0, 0, 0});
  const std::vector<Face> faces = resting_faces(scene);
  const wire::ImageOutputs outputs = wire::with_sources(wire::ImageOutputs(wire::kAmodal));
  for (const uint32_t samples : {1u, 4u}) {
    RenderBench bench(scene, kLabelExtent, plain(samples));
    const Taken taken = bench.take(state::PoseState(scene), view_through(eye), outputs);
    const sinks::Amodal amodal = silhouettes_of(taken, scene);
    const auto seen = taken.plane<uint32_t>(wire::kInstanceU32);
    ASSERT_EQ(amodal.records.size(), 4u);
    ASSERT_EQ(amodal.masks.size(), size_t{4} * kLabelExtent.height * ((kLabelExtent.width + 7) / 8));
    size_t hidden = 0;
    for (size_t r = 0; r < 4; ++r) {
      const wire::AmodalRecord& record = amodal.records[r];
      EXPECT_EQ(record.instance, r + 1);
      EXPECT_EQ(record.semantic, 10 + r);
      EXPECT_EQ(record.is_truncated, r == 0 || r == 3 ? 1u : 0u) << "the wall and the box at the border";
      std::vector<Face> alone;
      for (const Face& face : faces)
        if (face.instance == record.instance) alone.push_back(face);
      uint32_t pixels = 0, visible = 0, left = kLabelExtent.width, right = 0, top = kLabelExtent.height,
               bottom = 0;
      for (uint32_t y = 0; y < kLabelExtent.height; ++y) {
        for (uint32_t x = 0; x < kLabelExtent.width; ++x) {
          const bool is_visible = seen[size_t{y} * kLabelExtent.width + x] == record.instance;
          visible += is_visible ? 1 : 0;
          if (has_pixel(amodal, r, x, y)) {
            ++pixels;
            left = std::min(left, x), right = std::max(right, x + 1);
            top = std::min(top, y), bottom = std::max(bottom, y + 1);
          }
          const auto hit = eye.cast_surely(alone, {x, y});
          if (!hit) continue;
          hidden += hit->instance != 0 && !is_visible ? 1 : 0;
          ASSERT_EQ(has_pixel(amodal, r, x, y), hit->instance != 0 || is_visible)
              << "at " << x << ", " << y << " of " << record.instance;
        }
      }
      EXPECT_EQ(record.pixels, pixels);
      EXPECT_EQ(record.visible_pixels, visible);
      EXPECT_EQ(std::vector({record.min_x, record.max_x, record.min_y, record.max_y}),
                std::vector({left, right, top, bottom}));
    }
    EXPECT_GT(hidden, 300u);
  }
}

// A triangle through the eye's plane, and one larger than the image, are clipped as in the image.
TEST_F(Labels, SilhouettesOfClippedTriangles) {
  SceneBuilder builder;
  builder.mesh_node("floor", builder.quad(builder.material(matte({0.5f, 0.5f, 0.5f})), 1000), glm::mat4(1));
  builder.camera_node("camera", {0, 1, 0}, {0, 0.5f, -1});
  const scene::Scene scene = builder.build();
  const Eye eye = eye_at({0, 1, 0}, {0, 0.7f, -1});
  RenderBench bench(scene, kLabelExtent, plain());
  const Taken taken = bench.take(state::PoseState(scene), view_through(eye),
                                 wire::with_sources(wire::ImageOutputs(wire::kAmodal)));
  const sinks::Amodal amodal = silhouettes_of(taken, scene);
  const auto seen = taken.plane<uint32_t>(wire::kInstanceU32);
  ASSERT_EQ(amodal.records.size(), 1u);
  EXPECT_EQ(amodal.records[0].pixels, static_cast<uint32_t>(std::ranges::count(seen, 1u)));
  EXPECT_EQ(amodal.records[0].visible_pixels, amodal.records[0].pixels) << "self-occlusion does not count";
  EXPECT_EQ(amodal.records[0].is_truncated, 1u);
}

// A film and a pane of glass before a wall. The limit decides, whatever the ray effects; colours stay.
scene::Scene film_and_glass(float film_alpha) {
  SceneBuilder builder;
  scene::Material film = matte({0.1f, 0.7f, 0.9f}), glass = matte({1, 1, 1});
  film.base_color.a = film_alpha;
  film.alpha_mode = scene::AlphaMode::blend;
  glass.transmission = 0.9f;
  const glm::mat4 upright = glm::rotate(glm::mat4(1), 1.5707963f, glm::vec3(1, 0, 0));
  builder.mesh_node("wall", builder.quad(builder.material(matte({0.25f, 0.5f, 0.75f})), 4), upright);
  builder.mesh_node("film", builder.box(builder.material(film), {0.4f, 0.4f, 0.1f}), at({-0.7f, 0, 1}));
  builder.mesh_node("glass", builder.box(builder.material(glass), {0.4f, 0.4f, 0.1f}), at({0.7f, 0, 1}));
  builder.light_node(sun({1, 1, 1}, 2), shining_towards({-0.3f, -1, -1}));
  builder.camera_node("camera", {0, 0, 4}, {0, 0, 0});
  return builder.build();
}

TEST_F(Labels, LimitOfAlphaAloneDecides) {
  const Eye eye = eye_at({0, 0, 4}, {0, 0, 0});
  const auto at_pixel = [](const auto& plane, const Eye& from, glm::dvec3 point) {
    const glm::dvec2 place = glm::round(from.project(point));
    return plane[static_cast<size_t>(place.y) * kLabelExtent.width + static_cast<size_t>(place.x)];
  };
  const glm::dvec3 film(-0.7, 0, 1.1), glass(0.7, 0, 1.1);
  for (const bool refracts : {false, true}) {
    const wire::ImageOutputs outputs(wire::kColorSrgb8 | wire::kInstanceU32 | wire::kDepthF32);
    for (const uint32_t samples : {1u, 4u}) {
      for (const float alpha : {0.3f, 0.7f}) {
        SCOPED_TRACE(std::to_string(alpha) + ", samples " + std::to_string(samples));
        const scene::Scene scene = film_and_glass(alpha);
        const state::PoseState poses(scene);
        settings::DrawSettings settings = plain(samples);
        settings.ray_effects.on.refraction = refracts;
        settings.label_alpha = 1;
        RenderBench none(scene, kLabelExtent, settings);
        const std::vector<uint8_t> colors = none.take(poses, view_through(eye), outputs).image.rgba8;
        for (const float limit : {0.5f, 0.8f}) {
          settings.label_alpha = limit;
          RenderBench bench(scene, kLabelExtent, settings);
          const Taken taken = bench.take(poses, view_through(eye), outputs);
          EXPECT_TRUE(taken.image.rgba8 == colors);
          const auto instance = taken.plane<uint32_t>(wire::kInstanceU32);
          const auto depth = taken.plane<float>(wire::kDepthF32);
          const bool has_film = alpha > limit;
          EXPECT_EQ(at_pixel(instance, eye, film), has_film ? 2u : 1u);
          EXPECT_NEAR(at_pixel(depth, eye, film), has_film ? 2.9 : 4.0, 1e-4);
          EXPECT_EQ(at_pixel(instance, eye, glass), 3u);
          EXPECT_NEAR(at_pixel(depth, eye, glass), 2.9, 1e-4);
        }
      }
    }
  }
}

// A pane whose texture is transparent on the left, and nearly so on the right.
scene::Scene tinted_pane() {
  SceneBuilder builder;
  scene::Material pane = matte({0.2f, 0.6f, 0.9f});
  pane.alpha_mode = scene::AlphaMode::blend;
  pane.double_sided = true;
  pane.base_color_texture.texture =
      builder.texture(64, 64, false, [](float u, float) { return glm::vec4(1, 1, 1, u < 0.5f ? 0 : 0.1f); });
  const glm::mat4 upright = glm::rotate(glm::mat4(1), 1.5707963f, glm::vec3(1, 0, 0));
  builder.mesh_node("wall", builder.quad(builder.material(matte({0.25f, 0.5f, 0.75f})), 4), upright);
  builder.mesh_node("pane", builder.quad(builder.material(pane), 1), at({0, 0, 1}) * upright);
  builder.camera_node("camera", {0, 0, 4}, {0, 0, 0});
  return builder.build();
}

uint32_t instance_at(const Taken& taken, const Eye& eye, glm::dvec3 point) {
  const glm::dvec2 place = glm::round(eye.project(point));
  return taken.plane<uint32_t>(
      wire::kInstanceU32)[static_cast<size_t>(place.y) * kLabelExtent.width + static_cast<size_t>(place.x)];
}

// With a limit of 0, whatever is not fully transparent has labels.
TEST_F(Labels, LimitOfZeroLeavesOutTransparentPixels) {
  const Eye eye = eye_at({0, 0, 4}, {0, 0, 0});
  const scene::Scene scene = tinted_pane();
  const state::PoseState poses(scene);
  for (const float limit : {0.0f, 0.2f}) {
    settings::DrawSettings settings = plain();
    settings.label_alpha = limit;
    RenderBench bench(scene, kLabelExtent, settings);
    const auto outputs = wire::with_sources(wire::ImageOutputs(wire::kInstanceU32 | wire::kAmodal));
    const Taken taken = bench.take(poses, view_through(eye), outputs);
    EXPECT_EQ(instance_at(taken, eye, {-0.5, 0, 1}), 1u);
    EXPECT_EQ(instance_at(taken, eye, {0.5, 0, 1}), limit == 0 ? 2u : 1u);
    const sinks::Amodal amodal = silhouettes_of(taken, scene);
    EXPECT_EQ(amodal.records.size(), limit == 0 ? 2u : 1u);
  }
}

// Edits decide which blended surfaces have labels, and which nodes a run warns of.
TEST_F(Labels, EditsChangeWhatHasLabels) {
  const Eye eye = eye_at({0, 0, 4}, {0, 0, 0});
  const scene::Scene scene = film_and_glass(0.3f);
  constexpr uint32_t kFilm = 1;
  RenderBench bench(scene, kLabelExtent, plain());
  scene::SceneEdits edits;
  bench.renderer().set_edits(edits);
  const state::PoseState poses(scene);
  const auto film = [&] {
    return instance_at(bench.take(poses, view_through(eye), wire::ImageOutputs(wire::kInstanceU32)), eye,
                       {-0.7, 0, 1.1});
  };
  const auto warned = [&] { return passes::nodes_without_labels(scene, &edits, 0.5f); };
  EXPECT_EQ(film(), 1u);
  EXPECT_EQ(warned(), std::vector{kFilm});
  EXPECT_EQ(passes::nodes_without_labels(scene, nullptr, 0.5f), std::vector{kFilm});
  edits.set(scene, {{kFilm, scene::NodeEdit{.base_color = glm::vec4(1, 0, 0, 0.8f)}}});
  EXPECT_EQ(film(), 2u);
  EXPECT_TRUE(warned().empty());
  edits.set(scene, {});
  const uint32_t material = scene.primitives[scene.meshes[scene.nodes[kFilm].mesh].first_primitive].material;
  scene::MaterialFactors factors = scene::factors_of(scene.materials[material]);
  factors.base_color.a = 0.9f;
  edits.set_materials({{material, factors}});
  EXPECT_EQ(film(), 2u);
  EXPECT_TRUE(warned().empty());
  edits.set_materials({});
  edits.set(scene, {{kFilm, scene::NodeEdit{.hidden = true}}});
  EXPECT_TRUE(warned().empty()) << "hidden";
}

scene::Scene tinted_film_alone(float alpha) {
  SceneBuilder builder;
  scene::Material film = matte({0.1f, 0.7f, 0.9f});
  film.base_color.a = alpha;
  film.alpha_mode = scene::AlphaMode::blend;
  builder.mesh_node("wall", builder.quad(builder.material(matte({0.25f, 0.5f, 0.75f})), 4), glm::mat4(1));
  builder.mesh_node("film", builder.box(builder.material(film), {0.4f, 0.4f, 0.1f}), at({0, 0, 1}));
  builder.camera_node("camera", {0, 0, 4}, {0, 0, 0});
  return builder.build();
}

// Images without surfaces to overlay do not copy the visibility buffer: of lines, and of blended surfaces
// whose alpha cannot exceed the limit.
TEST_F(Labels, NothingIsCopiedWithoutBlendedLabels) {
  const Eye eye = eye_at({0, 0, 4}, {0, 0, 0});
  const auto copies_ids = [&](const scene::Scene& scene) {
    RenderBench bench(scene, kLabelExtent, plain());
    const state::PoseState poses(scene);
    bench.take(poses, view_through(eye), wire::ImageOutputs(wire::kInstanceU32));
    bool copies = false;
    for (const gpu::FrameTimes& frame : bench.frames().take_finished())
      for (const gpu::PassTime& pass : frame.passes) copies |= pass.name == std::string_view("copy ids");
    return copies;
  };
  EXPECT_TRUE(copies_ids(film_and_glass(0.7f)));
  EXPECT_FALSE(copies_ids(tinted_film_alone(0.3f)));
  EXPECT_TRUE(copies_ids(tinted_film_alone(0.7f)));
  scene::Scene lines = tinted_film_alone(1);
  scene::Primitive& last = lines.primitives.back();
  lines.materials[last.material].alpha_mode = scene::AlphaMode::opaque;
  last.topology = scene::Topology::lines;
  EXPECT_FALSE(copies_ids(lines));
}

// Labels of path-traced images are those of the raster, blended surfaces included.
TEST_F(Labels, PathTracedImagesHaveTheSame) {
  const Eye eye = eye_at({0, 0, 4}, {0, 0, 0});
  const scene::Scene scene = film_and_glass(0.7f);
  const state::PoseState poses(scene);
  const wire::ImageOutputs outputs =
      wire::with_sources(wire::ImageOutputs(wire::kColorSrgb8 | wire::kDepthF32 | wire::kAmodal));
  RenderBench raster(scene, kLabelExtent, plain(4));
  const Taken of_raster = raster.take(poses, view_through(eye), outputs);
  settings::DrawSettings settings = plain(4);
  settings.path.emplace();
  settings.path->samples_per_pixel = 1;
  settings.path->bounces = 1;
  RenderBench paths(scene, kLabelExtent, settings);
  const Taken of_paths = paths.take(poses, view_through(eye), outputs);
  for (const wire::ImageOutput output : {wire::kDepthF32, wire::kInstanceU32, wire::kAmodal})
    EXPECT_EQ(of_paths.plane<uint8_t>(output), of_raster.plane<uint8_t>(output)) << uint32_t{output};
}

}  // namespace
}  // namespace fire3dv::test
