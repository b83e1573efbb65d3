// Render test of the tiles of large screenshots: put together, they are the image that is drawn at once, also
// with post-process antialiasing, shadows and the background, except for rounding.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "renderer/window/screenshots/screenshot_tiles.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kWholeExtent{240, 150};
constexpr uint32_t kSide = 120;

scene::Scene still_life() {
  SceneBuilder builder;
  const uint32_t floor = builder.quad(builder.material(matte({0.6f, 0.6f, 0.55f})), 8);
  const uint32_t ball = builder.sphere(builder.material(matte({0.2f, 0.4f, 0.8f})), 0.5f, 32);
  const uint32_t box = builder.box(builder.material(matte({0.8f, 0.3f, 0.2f})), {0.4f, 0.8f, 0.4f});
  builder.mesh_node("floor", floor, glm::mat4(1));
  for (int i = 0; i < 5; ++i) {
    const auto x = static_cast<float>(i - 2);
    builder.mesh_node("ball", ball, at({1.1f * x, 0.5f, 0.3f * x}));
    builder.mesh_node("box", box, at({1.1f * x + 0.4f, 0.8f, -1.5f}));
  }
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({-0.6f, -1, -0.4f}));
  builder.camera_node("camera", {0, 2, 5}, {0, 0.6f, 0}, 0.9f);
  return builder.build();
}

class ScreenshotTilesImage : public ValidationIsSilent {};

struct Difference {
  size_t by_one = 0, by_more = 0;  // bytes
  int most = 0;
};

// Draws the view at once and in tiles, and compares.
Difference difference_of_tiles(const settings::DrawSettings& settings) {
  const scene::Scene scene = still_life();
  const state::PoseState poses(scene);
  RenderBench bench(scene, kWholeExtent, settings);
  const passes::View view = first_camera_view(scene, poses, kWholeExtent);
  const sinks::FrameImage whole = bench.draw(poses, view);
  std::vector<uint8_t> joined(whole.rgba8.size());
  const std::vector<app::ScreenshotTile> tiles =
      app::screenshot_tiles({kWholeExtent.width, kWholeExtent.height}, kSide);
  EXPECT_GT(tiles.size(), 4u);
  for (const app::ScreenshotTile& tile : tiles) {
    bench.set_size({tile.drawn_size.x, tile.drawn_size.y});
    const sinks::FrameImage part =
        bench.draw(poses, app::view_of_tile(view, {kWholeExtent.width, kWholeExtent.height}, tile));
    const glm::uvec2 offset = tile.kept_low - tile.drawn_low;
    for (uint32_t y = 0; y < tile.kept_size.y; ++y) {
      std::copy_n(part.rgba8.data() + 4 * (size_t{offset.y + y} * tile.drawn_size.x + offset.x),
                  4 * size_t{tile.kept_size.x},
                  joined.data() + 4 * (size_t{tile.kept_low.y + y} * kWholeExtent.width + tile.kept_low.x));
    }
  }
  Difference found;
  for (size_t i = 0; i < joined.size(); ++i) {
    const int difference = std::abs(int{joined[i]} - int{whole.rgba8[i]});
    found.by_one += difference == 1 ? 1 : 0;
    found.by_more += difference > 1 ? 1 : 0;
    found.most = std::max(found.most, difference);
  }
  return found;
}

// Vertices and the origins of shadow rays have other last bits in a tile: its projection and its rays are
// other floats. Rarely a vertex rounds to another subpixel, or a ray from an edge meets another surface.
TEST_F(ScreenshotTilesImage, AreTheWholeImage) {
  const size_t bytes = 4 * size_t{kWholeExtent.width} * kWholeExtent.height;
  settings::DrawSettings maps;
  maps.shadows.method = settings::ShadowMethod::map;
  const Difference without_rays = difference_of_tiles(maps);
  EXPECT_LE(without_rays.by_one + without_rays.by_more, bytes / 10'000) << "by " << without_rays.most;
  const Difference with_rays = difference_of_tiles({});
  EXPECT_LE(with_rays.by_one, bytes / 1000) << "by " << with_rays.most;
  EXPECT_LE(with_rays.by_more, bytes / 4000) << "by " << with_rays.most;
  EXPECT_LE(with_rays.most, 24);
}

}  // namespace
}  // namespace fire3dv::test
