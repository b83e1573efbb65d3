// Render test of the coverage merge: connected small triangles of a pixel are shaded as one surface in scenes
// with enough triangles. The image matches the forward path.
#include <algorithm>

#include "tests/render/support/proof_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kMergeExtent{128, 96};

class MergedSurfaces : public ValidationIsSilent {
 protected:
  struct Drawn {
    sinks::FrameImage image;
    bool merged = false;
  };

  static Drawn drawn(uint32_t segments, const settings::DrawSettings& settings) {
    SceneBuilder builder;
    builder.mesh_node("ball", builder.sphere(builder.material(matte({0.8f, 0.4f, 0.2f})), 0.8f, segments),
                      glm::mat4(1));
    builder.light_node(sun({1, 1, 1}, 3), shining_towards({-1, -1, -0.5f}));
    builder.camera_node("camera", {0, 0, 3}, {0, 0, 0});
    const scene::Scene scene = builder.build();
    RenderBench bench(scene, kMergeExtent, settings);
    Drawn result{bench.draw_at_rest()};
    for (const gpu::FrameTimes& times : bench.frames().take_finished()) {
      for (const gpu::PassTime& pass : times.passes)
        result.merged |= std::string_view(pass.name) == "coverage merge";
    }
    return result;
  }
};

TEST_F(MergedSurfaces, MergedImageIsIdentical) {
  settings::DrawSettings settings = plain_settings(4);
  const Drawn merged = drawn(128, settings);  // several triangles in each pixel
  EXPECT_TRUE(merged.merged);
  settings.raster = settings::RasterPath::forward;
  const Drawn reference = drawn(128, settings);
  EXPECT_FALSE(reference.merged);
  EXPECT_TRUE(matches_image(merged.image, reference.image, "merged_surfaces", Tolerance::colour()));
}

TEST_F(MergedSurfaces, FewTrianglesAreNotMerged) {
  EXPECT_FALSE(drawn(12, plain_settings(4)).merged);
}

}  // namespace
}  // namespace fire3dv::test
