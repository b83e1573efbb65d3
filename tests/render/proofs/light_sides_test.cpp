// Render test of the sides of surfaces that light reaches: opaque surfaces are black to light from behind
// their triangles, whatever their normals, and coarse smooth-shaded bodies have the terminator of fine ones.
// All shadow techniques and paths agree.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/render/support/path_bench.h"
#include "tests/render/support/proof_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

using glm::vec3;
using settings::RayBackEnd;
using settings::ShadowMethod;

constexpr VkExtent2D kSides{48, 48};
constexpr float kAlbedo = 0.8f;

// One renderer for all scenes.
class Technique {
 public:
  Technique(std::string name, const settings::DrawSettings& settings)
      : name(std::move(name)), bench_(nothing_, kSides, settings) {}

  std::vector<glm::dvec3> draw(const scene::Scene& scene) {
    bench_.renderer().set_scene(scene);
    return linear_image(bench_, scene, kSides);
  }
  const std::string name;

 private:
  scene::Scene nothing_ = SceneBuilder().build();
  RenderBench bench_;
};

settings::DrawSettings traced_by(RayBackEnd back_end, bool hybrid) {
  settings::DrawSettings settings = shadowed_by(ShadowMethod::ray, hybrid);
  settings.shadows.back_end = back_end;
  return settings;
}

settings::DrawSettings forward_rays() {
  settings::DrawSettings settings = shadowed_by(ShadowMethod::ray, false);
  settings.raster = settings::RasterPath::forward;
  return settings;
}

class LightSides : public ValidationIsSilent {
 protected:
  static std::vector<std::unique_ptr<Technique>>& techniques() {
    static std::vector<std::unique_ptr<Technique>> all;
    if (!all.empty()) return all;
    const auto add = [&](const char* name, const settings::DrawSettings& settings) {
      all.push_back(std::make_unique<Technique>(name, settings));
    };
    add("rays", traced_by(RayBackEnd::query, false));
    add("hybrid", traced_by(RayBackEnd::query, true));
    add("ray pipeline", traced_by(RayBackEnd::pipeline, false));
    add("maps", shadowed_by(ShadowMethod::map, false));
    add("paths, direct light", path_settings(16, 0));
    add("paths, 8 bounces", path_settings(4, 8));
    return all;
  }
  static void TearDownTestSuite() {
    techniques().clear();
    device().retire_all_now();
  }
};

double sum_of(const std::vector<glm::dvec3>& pixels) {
  double sum = 0;
  for (const glm::dvec3& pixel : pixels) sum += pixel.r + pixel.g + pixel.b;
  return sum;
}

// Seen from above, lit along +X from this elevation. The normal leans to the lamp, by the normal map or by
// the vertices.
scene::Scene leaning_sheet(float lean_deg, bool mapped, bool double_sided, float elevation_deg) {
  const float lean = glm::radians(lean_deg), elevation = glm::radians(elevation_deg);
  const vec3 normal(std::sin(lean), std::cos(lean), 0);
  SceneBuilder builder;
  scene::Material material = lambert(vec3(kAlbedo));
  material.double_sided = double_sided;
  if (mapped) {
    const vec3 texel = vec3(normal.x, 0, normal.y) * 0.5f + 0.5f;
    material.normal_texture.texture =
        builder.texture(4, 4, false, [&](float, float) { return glm::vec4(texel, 1); });
  }
  const uint32_t index = builder.material(material);
  std::vector<vec3> corners{{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
  std::vector<scene::VertexAttributes> attributes(4);
  for (size_t i = 0; i < 4; ++i)
    attributes[i] = {
        .tangent = glm::vec4(1, 0, 0, 1), .uv0 = {}, .uv1 = {}, .normal = mapped ? vec3(0, 1, 0) : normal};
  builder.mesh_node("sheet", builder.mesh(index, corners, attributes, {0, 1, 2, 0, 2, 3}), glm::mat4(1));
  builder.light_node(sun(vec3(1), 1), shining_towards(-vec3(std::cos(elevation), std::sin(elevation), 0)));
  builder.camera_node("camera", {0, 3, 0.01f}, {0, 0, 0}, 0.3f);
  return builder.build();
}

TEST_F(LightSides, LampsBelowSheetsDoNotShineThrough) {
  for (const bool mapped : {true, false}) {
    for (const float elevation : {-5.0f, -15.0f, -30.0f}) {
      const scene::Scene scene = leaning_sheet(40, mapped, mapped, elevation);
      for (auto& technique : techniques())
        EXPECT_EQ(sum_of(technique->draw(scene)), 0)
            << technique->name << ", " << elevation << " degrees, " << (mapped ? "map" : "vertices");
    }
    const scene::Scene scene = leaning_sheet(40, mapped, true, 30);
    for (auto& technique : techniques())
      EXPECT_NEAR(estimate(technique->draw(scene)).mean, kAlbedo / kPi * std::cos(glm::radians(20.0)), 2e-3)
          << technique->name;
  }
}

scene::Scene inside_of_ball(uint32_t segments) {
  SceneBuilder builder;
  builder.mesh_node("ball", builder.sphere(builder.material(lambert(vec3(kAlbedo))), 1, segments),
                    glm::mat4(1));
  builder.light_node(sun(vec3(1), 3), shining_towards({-3, -2, -1}));
  builder.camera_node("camera", {0, 0, 0.5f}, {0, 0, -1}, 1.4f);
  return builder.build();
}

TEST_F(LightSides, ClosedBallsAreBlackInside) {
  for (const uint32_t segments : {12u, 24u, 64u}) {
    const scene::Scene scene = inside_of_ball(segments);
    for (auto& technique : techniques()) {
      // The bias of maps lights the ring where walls of both sides meet along the light's direction.
      const double most = technique->name == "maps" ? 1.5e-3 * 3 * kAlbedo / kPi : 0;
      EXPECT_LE(sum_of(technique->draw(scene)) / (3 * kSides.width * kSides.height), most)
          << technique->name << ", " << segments << " segments";
    }
  }
}

TEST_F(LightSides, DarkSideOfBumpyBallIsBlack) {
  SceneBuilder builder;
  scene::Material material = lambert(vec3(kAlbedo));
  material.normal_texture.texture = builder.texture(256, 256, false, [](float u, float v) {
    const vec3 n = glm::normalize(vec3(0.8f * std::cos(50 * u), 0.8f * std::sin(50 * v), 1));
    return glm::vec4(n * 0.5f + 0.5f, 1);
  });
  builder.mesh_node("ball", builder.sphere(builder.material(material), 0.8f, 64), glm::mat4(1));
  builder.light_node(sun(vec3(1), 2.5f), shining_towards({0, 0, 1}));
  builder.camera_node("camera", {0, 0, 3}, {0, 0, 0}, 0.3f);
  const scene::Scene scene = builder.build();
  for (auto& technique : techniques()) EXPECT_EQ(sum_of(technique->draw(scene)), 0) << technique->name;
}

scene::Scene half_lit_ball(uint32_t segments) {
  SceneBuilder builder;
  scene::Material material = lambert(vec3(kAlbedo));
  material.double_sided = false;
  builder.mesh_node("ball", builder.sphere(builder.material(material), 0.8f, segments), glm::mat4(1));
  builder.light_node(sun(vec3(1), 3), shining_towards({-1, -0.3f, -0.1f}));
  builder.camera_node("camera", {0, 0, 3}, {0, 0, 0}, 0.63f);
  return builder.build();
}

// Pixels within 0.9 of the radius: the silhouettes differ.
TEST_F(LightSides, CoarseBallsHaveTerminatorOfFineOnes) {
  const std::vector<glm::dvec3> fine = techniques().front()->draw(half_lit_ball(128));
  for (const uint32_t segments : {16u, 24u}) {
    const scene::Scene scene = half_lit_ball(segments);
    for (auto& technique : techniques()) {
      const std::vector<glm::dvec3> coarse = technique->draw(scene);
      double error = 0, sum = 0, largest = 0;
      uint32_t compared = 0;
      for (uint32_t y = 0; y < kSides.height; ++y) {
        for (uint32_t x = 0; x < kSides.width; ++x) {
          if (std::hypot(x - 23.5, y - 23.5) > 0.9 * 19.5) continue;
          const size_t i = size_t{y} * kSides.width + x;
          error += std::abs(coarse[i].g - fine[i].g);
          largest = std::max(largest, std::abs(coarse[i].g - fine[i].g));
          sum += fine[i].g;
          ++compared;
        }
      }
      const double level = kAlbedo / kPi * 3;
      const std::string what = technique->name + ", " + std::to_string(segments) + " segments";
      RecordProperty(what, std::to_string(error / sum) + ", largest " + std::to_string(largest / level));
      EXPECT_LT(error / sum, 0.03) << what;
      EXPECT_LT(largest / level, 0.06) << what;
      EXPECT_GT(compared, 900u);
    }
  }
}

TEST_F(LightSides, ForwardPathHasSameSides) {
  const std::array scenes{half_lit_ball(16), inside_of_ball(12), leaning_sheet(40, true, true, -5),
                          leaning_sheet(40, false, false, -5)};
  ProofBench forward(kSides, forward_rays()), visibility(kSides, traced_by(RayBackEnd::query, false));
  for (const scene::Scene& scene : scenes) {
    forward.show(scene);
    visibility.show(scene);
    EXPECT_TRUE(matches_image(forward.draw_first_camera(), visibility.draw_first_camera(),
                              "light_sides_forward", Tolerance::colour()));
  }
}

}  // namespace
}  // namespace fire3dv::test
