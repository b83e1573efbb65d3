// Golden image test of the scenes of docs/gallery.md, loaded and drawn at a smaller size.
#include <gtest/gtest.h>

#include "examples/gallery/scenes.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/render/support/render_bench.h"
#include "tests/support/gltf_builder.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

class Gallery : public ValidationIsSilent {
 protected:
  static scene::Scene load(const std::string& name) {
    const ScratchFolder folder;
    for (const gallery::SceneFile& file : gallery::make_scenes()) {
      if (file.name != name + ".glb") continue;
      Result<scene::Scene> scene =
          scene::load_gltf(folder.write(file.name, std::as_bytes(std::span(file.bytes))));
      EXPECT_TRUE(scene.ok()) << scene.error().message;
      EXPECT_TRUE(scene->warnings.empty()) << scene->warnings.front();
      return std::move(*scene);
    }
    ADD_FAILURE() << "no scene is called " << name;
    return {};
  }
};

TEST_F(Gallery, FiveMaterials) {
  const scene::Scene scene = load("material_spheres");
  settings::DrawSettings settings;
  settings.background.show_environment = true;
  settings.post.tone_map = settings::ToneMap::neutral;
  settings.post.exposure = 1.5f;
  RenderBench bench(scene, {320, 120}, settings);
  EXPECT_TRUE(matches_golden(bench.draw_at_rest(), "gallery_material_spheres", Tolerance::colour()));
}

TEST_F(Gallery, EdgesWithAndWithoutAntiAliasing) {
  const scene::Scene scene = load("edges");
  for (const bool fxaa : {false, true}) {
    for (const uint32_t samples : {1u, 4u}) {
      settings::DrawSettings settings;
      settings.samples = samples;
      settings.post.fxaa = fxaa;
      RenderBench bench(scene, {120, 90}, settings);
      EXPECT_TRUE(matches_golden(bench.draw_at_rest(),
                                 "gallery_edges_" + std::to_string(samples) + (fxaa ? "_fxaa" : ""),
                                 Tolerance::colour()));
    }
  }
}

TEST_F(Gallery, ShadowsOfTwoLights) {
  const scene::Scene scene = load("two_lights");
  RenderBench bench(scene, {320, 200});
  EXPECT_TRUE(matches_golden(bench.draw_at_rest(), "gallery_two_lights", Tolerance::colour()));
}

}  // namespace
}  // namespace fire3dv::test
