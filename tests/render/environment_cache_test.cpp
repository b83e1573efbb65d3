// Render test of cached environment maps: a cache entry gives the same image as a prepared environment, and
// its key separates devices, images, sizes and recipes.
#include <gtest/gtest.h>

#include <map>

#include "renderer/passes/environment/environment.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

class CachedEnvironment : public ValidationIsSilent {};

class Shelf : public passes::EnvironmentStore {
 public:
  std::optional<std::vector<std::byte>> find(const fire3dv::Digest& kind, size_t bytes) override {
    const auto kept = kept_.find(kind);
    if (kept == kept_.end()) return std::nullopt;
    EXPECT_EQ(kept->second.size(), bytes);
    ++found;
    return kept->second;
  }
  void keep(const fire3dv::Digest& kind, std::span<const std::byte> maps) override {
    kept_[kind] = {maps.begin(), maps.end()};
  }
  size_t size() const { return kept_.size(); }
  uint32_t found = 0;

 private:
  std::map<fire3dv::Digest, std::vector<std::byte>> kept_;
};

// Coated materials of several roughnesses in an environment without symmetry.
TEST_F(CachedEnvironment, CachedMapsGiveSameBytes) {
  SceneBuilder builder;
  for (int i = 0; i < 3; ++i) {
    scene::Material material = matte({0.9f, 0.6f, 0.3f});
    material.metallic = 0.5f;
    material.roughness = 0.4f * static_cast<float>(i);
    material.clearcoat = 1;
    builder.mesh_node("ball", builder.sphere(builder.material(material), 1, 32),
                      at({2.1f * static_cast<float>(i - 1), 0, 0}));
  }
  builder.camera_node("camera", {0, 1, 6}, {0, 0, 0});
  const scene::Scene scene = builder.build();
  const auto shelf = std::make_shared<Shelf>();
  const auto draw = [&](float red, bool kept) {
    settings::DrawSettings settings;
    settings.environment =
        std::make_shared<scene::EnvironmentImage>(scene::make_environment(256, 128, [&](const glm::vec3& d) {
          return glm::abs(d) * glm::vec3(red, 1, 2) + glm::max(d, 0.0f);
        }));
    settings.post.tone_map = settings::ToneMap::none;
    settings.post.fxaa = false;
    settings.background.show_environment = true;
    if (kept) settings.cached_environments = shelf;
    return RenderBench(scene, {96, 64}, settings).draw_at_rest();
  };
  const sinks::FrameImage prepared = draw(1, false);
  EXPECT_EQ(draw(1, true).rgba8, prepared.rgba8);
  EXPECT_EQ(shelf->size(), 1u);
  EXPECT_EQ(shelf->found, 0u);
  EXPECT_EQ(draw(1, true).rgba8, prepared.rgba8);
  EXPECT_EQ(shelf->found, 1u);
  EXPECT_NE(draw(3, true).rgba8, prepared.rgba8);  // an environment of another image
  EXPECT_EQ(shelf->size(), 2u);
}

TEST(KeptEnvironments, KeyFollowsDeviceSizeAndRecipe) {
  VkPhysicalDeviceProperties device{};
  scene::EnvironmentImage image{4, 2, std::vector<uint32_t>(8, 7), 1};
  std::vector<uint32_t> recipe{1, 23};
  const fire3dv::Digest kind = passes::environment_kind(device, image, recipe);
  EXPECT_EQ(passes::environment_kind(device, image, recipe), kind);
  device.driverVersion = 1;
  EXPECT_NE(passes::environment_kind(device, image, recipe), kind);
  device.driverVersion = 0;
  image.width = 2;
  image.height = 4;
  EXPECT_NE(passes::environment_kind(device, image, recipe), kind);
  std::swap(image.width, image.height);
  image.rgb9e5[5] = 6;
  EXPECT_NE(passes::environment_kind(device, image, recipe), kind);
  image.rgb9e5[5] = 7;
  recipe = {12, 3};
  EXPECT_NE(passes::environment_kind(device, image, recipe), kind);
  recipe = {1, 23};
  image.scale = 3;  // the scale is not part of the maps
  EXPECT_EQ(passes::environment_kind(device, image, recipe), kind);
}

}  // namespace
}  // namespace fire3dv::test
