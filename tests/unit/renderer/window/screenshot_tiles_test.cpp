// Tests of large screenshots: limits of their size; tiles cover each pixel once with a margin around it, and
// a point has the same pixel and depth in a tile as in the whole image.
#include "renderer/window/screenshots/screenshot_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "renderer/gui/screenshot_size.h"
#include "renderer/scene/model/appearance.h"

namespace fire3dv::app {
namespace {

TEST(ScreenshotTiles, TilesCoverEachPixel) {
  constexpr uint32_t kSide = 100;
  for (const glm::uvec2 image :
       {glm::uvec2(100, 40), {101, 40}, {136, 100}, {137, 300}, {1, 1000}, {555, 333}}) {
    std::vector<int> covered(size_t{image.x} * image.y);
    const std::vector<ScreenshotTile> tiles = screenshot_tiles(image, kSide);
    EXPECT_EQ(tiles.size() == 1, image.x <= kSide && image.y <= kSide);
    EXPECT_EQ(tiles.front().kept_low, glm::uvec2(0));
    for (const ScreenshotTile& tile : tiles) {
      EXPECT_EQ(tile.drawn_size, tiles.front().drawn_size) << "one size needs one set of targets";
      for (int axis = 0; axis < 2; ++axis) {
        const uint32_t low = tile.drawn_low[axis], high = low + tile.drawn_size[axis];
        const uint32_t kept = tile.kept_low[axis], kept_high = kept + tile.kept_size[axis];
        EXPECT_LE(tile.drawn_size[axis], kSide);
        EXPECT_LE(high, image[axis]);
        EXPECT_GE(kept, low == 0 ? 0 : low + kTileMargin_px);
        EXPECT_LE(kept_high, high == image[axis] ? high : high - kTileMargin_px);
      }
      for (uint32_t y = 0; y < tile.kept_size.y; ++y) {
        for (uint32_t x = 0; x < tile.kept_size.x; ++x)
          ++covered[size_t{image.x} * (tile.kept_low.y + y) + tile.kept_low.x + x];
      }
    }
    EXPECT_TRUE(std::all_of(covered.begin(), covered.end(), [](int count) { return count == 1; }));
  }
}

TEST(ScreenshotSize, LimitsAreNamed) {
  EXPECT_EQ(gui::parse_screenshot_size("7680x4320").value(), glm::uvec2(7680, 4320));
  EXPECT_EQ(gui::parse_screenshot_size("65536x4096").value(), glm::uvec2(65'536, 4096));
  for (const char* text : {"", "x", "640", "640x", "x480", "0x480", "640x0", "-1x9", "640x480x3", " 640x480",
                           "65537x1", "65536x4097", "4294967297x1", "640X480"}) {
    const Result<glm::uvec2> size = gui::parse_screenshot_size(text);
    ASSERT_FALSE(size) << text;
    EXPECT_NE(size.error().message.find("\"" + std::string(text) + "\""), std::string::npos);
    EXPECT_NE(size.error().message.find("65536"), std::string::npos);
  }
  using Kind = ScreenshotSize::Kind;
  const glm::uvec2 image(700, 400);
  EXPECT_EQ(gui::screenshot_px({Kind::window, ""}, image).value(), image);
  EXPECT_EQ(gui::screenshot_px({Kind::twice, ""}, image).value(), glm::uvec2(1400, 800));
  EXPECT_EQ(gui::screenshot_px({Kind::four_times, ""}, image).value(), glm::uvec2(2800, 1600));
  EXPECT_EQ(gui::screenshot_px({Kind::fixed, "31x7"}, image).value(), glm::uvec2(31, 7));
  const Result<glm::uvec2> large = gui::screenshot_px({Kind::four_times, ""}, {8192, 8192});
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().message.find("4 times 8192x8192"), std::string::npos) << large.error().message;
}

TEST(ScreenshotTiles, PointsMatchWholeImage) {
  constexpr glm::uvec2 kImage{300, 200};
  for (const bool orthographic : {false, true}) {
    scene::Camera camera;
    camera.orthographic = orthographic;
    camera.half_extent_m = {6, 4};
    camera.far_m = 50;
    const glm::mat4 pose = passes::look_at_pose({3, 2, 8}, {0, 0.5f, 0});
    const passes::View whole = passes::make_view(camera, pose, 1.5f);
    const auto pixel_of = [](const passes::View& view, glm::uvec2 size, const glm::vec3& at) {
      const glm::vec4 clip = view.clip_from_world * glm::vec4(at, 1);
      return glm::vec3((glm::vec2(clip) / clip.w * 0.5f + 0.5f) * glm::vec2(size), clip.z / clip.w);
    };
    for (const ScreenshotTile& tile : screenshot_tiles(kImage, 96)) {
      const passes::View view = view_of_tile(whole, kImage, tile);
      for (const glm::vec3 at : {glm::vec3(0, 0, 0), {1, 2, -3}, {-2, 0.3f, 1}}) {
        const glm::vec3 in_whole = pixel_of(whole, kImage, at), in_tile = pixel_of(view, tile.drawn_size, at);
        EXPECT_NEAR(in_tile.x + static_cast<float>(tile.drawn_low.x), in_whole.x, 1e-3f);
        EXPECT_NEAR(in_tile.y + static_cast<float>(tile.drawn_low.y), in_whole.y, 1e-3f);
        EXPECT_FLOAT_EQ(in_tile.z, in_whole.z);
      }
      const auto ray = [](const passes::View& v, glm::vec2 ndc) {
        return v.world_from_ndc_x * ndc.x + v.world_from_ndc_y * ndc.y + v.world_from_ndc_origin;
      };
      const glm::vec2 size(tile.drawn_size), low(tile.drawn_low), image(kImage), pixel(17.5f, 60.5f);
      const glm::vec3 a = ray(view, 2.0f * pixel / size - 1.0f);
      const glm::vec3 b = ray(whole, 2.0f * (pixel + low) / image - 1.0f);
      for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(a[axis], b[axis], 1e-6f);
      EXPECT_EQ(view.eye_world, whole.eye_world);
    }
  }
  const passes::View whole = passes::make_view({}, glm::mat4(1), 1);
  EXPECT_EQ(view_of_tile(whole, {64, 64}, screenshot_tiles({64, 64}, 96)[0]).clip_from_world,
            whole.clip_from_world);
}

}  // namespace
}  // namespace fire3dv::app
