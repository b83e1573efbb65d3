// Golden image test of a small ADF scene from each of its cameras: AMBF shapes and colours, a mesh with its
// own materials and one with an override, translucent and hidden bodies.
#include <gtest/gtest.h>

#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/render/support/render_bench.h"
#include "tests/support/gltf_builder.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

class AdfGolden : public ValidationIsSilent {
 protected:
  static scene::Scene converted() {
    convert::ReadOptions options;
    options.launch_indices = {0, 1, 2};
    const Result<convert::Model> model = convert::read_adf(
        std::filesystem::path(FIRE3DV_SOURCE_DIR) / "tests/assets/adf/launch.yaml", options);
    EXPECT_TRUE(model) << model.error().message;
    const Result<std::vector<std::byte>> glb = convert::write_glb(*model);
    EXPECT_TRUE(glb) << glb.error().message;
    const ScratchFolder folder;
    Result<scene::Scene> scene = scene::load_gltf(folder.write("adf.glb", *glb));
    EXPECT_TRUE(scene) << scene.error().message;
    return scene ? std::move(*scene) : scene::Scene{};
  }

  static void expect_golden(const char* camera, const char* name) {
    constexpr VkExtent2D extent{320, 240};
    const scene::Scene scene = converted();
    for (const settings::RasterPath path :
         {settings::RasterPath::forward, settings::RasterPath::visibility}) {
      SCOPED_TRACE(path == settings::RasterPath::forward ? "forward" : "visibility");
      settings::DrawSettings settings;
      settings.raster = path;
      RenderBench bench(scene, extent, settings);
      const state::PoseState poses(scene);
      for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
        if (scene.nodes[node].name != camera) continue;
        const passes::View view =
            passes::make_view(scene.cameras.at(scene.nodes[node].camera), poses.world_from_node(node),
                              extent.width * 1.0f / extent.height);
        EXPECT_TRUE(matches_golden(bench.draw(poses, view), name, Tolerance::colour()));
      }
    }
  }
};

TEST_F(AdfGolden, FromTheSide) {
  expect_golden("/ambf/env/cameras/side#view", "adf_side");
}
// The parent of the camera is a body without visible geometry.
TEST_F(AdfGolden, FromTheRightEye) {
  expect_golden("/ambf/env/cameras/stereo eye#right", "adf_right_eye");
}

}  // namespace
}  // namespace fire3dv::test
