// Image of an SDF world: boxes where a pinhole camera sees them, lit on the side that faces the light.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/render/support/render_bench.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kExtent{240, 180};
using Pixel = std::array<int, 3>;

class SdfWorld : public ValidationIsSilent {
 protected:
  // The camera stands at -5 m and looks along +X. Boxes of 1 m: red 1 m to its left, green 1 m to its right.
  sinks::FrameImage drawn(const std::string& light_direction) {
    const auto box = [](const std::string& name, const std::string& y, const std::string& color) {
      return "<model name='" + name + "'><static>true</static><pose>0 " + y +
             " 0 0 0 0</pose><link name='l'><visual name='v'><geometry><box><size>1 1 "
             "1</size></box></geometry>"
             "<material><diffuse>" +
             color + " 1</diffuse></material></visual></link></model>";
    };
    const std::string world =
        "<sdf version='1.9'><world name='w'><gui><camera name='c'><pose>-5 0 0 0 0 0</pose></camera></gui>"
        "<light name='sun' type='directional'><intensity>1</intensity><direction>" +
        light_direction + "</direction></light>" + box("red", "1", "1 0 0") + box("green", "-1", "0 1 0") +
        "</world></sdf>";
    const auto model = convert::read_description(folder_.write("world.sdf", std::string_view(world)), {});
    EXPECT_TRUE(model.ok()) << model.error().message;
    if (!model) return {};
    for (const std::string& warning : model->warnings) ADD_FAILURE() << warning;
    const auto glb = convert::write_glb(*model);
    EXPECT_TRUE(glb.ok());
    const auto scene = scene::load_glb(*glb, model->name);
    EXPECT_TRUE(scene.ok()) << scene.error().message;
    return scene ? RenderBench(*scene, kExtent).draw_at_rest() : sinks::FrameImage{};
  }

  static Pixel pixel(const sinks::FrameImage& image, uint32_t x, uint32_t y) {
    const size_t at = (size_t{y} * image.width + x) * 4;
    if (at + 3 > image.rgba8.size()) return {};
    return {image.rgba8[at], image.rgba8[at + 1], image.rgba8[at + 2]};
  }

  ScratchFolder folder_;
};

// Front faces are 4.5 m away. Half the image is 4.5 m * tan(1.047 / 2) = 2.6 m wide, so that 1 m is 46
// pixels: the faces are 46 pixels wide, with their middles 46 pixels left and right of that of the image.
TEST_F(SdfWorld, ShowsBoxesWhereTheyStand) {
  const sinks::FrameImage image = drawn("1 0 0");
  ASSERT_EQ(image.rgba8.size(), size_t{kExtent.width} * kExtent.height * 4);
  const Pixel background = pixel(image, 2, 2);
  for (const uint32_t dx : {0u, 20u})
    for (const uint32_t dy : {0u, 20u}) {
      const Pixel red = pixel(image, 120 - 46 + dx, 90 - dy), green = pixel(image, 120 + 46 - dx, 90 + dy);
      EXPECT_GT(red[0], 150);
      EXPECT_LT(std::max(red[1], red[2]), red[0] * 2 / 3);
      EXPECT_GT(green[1], 150);
      EXPECT_LT(std::max(green[0], green[2]), green[1] * 2 / 3);
    }
  EXPECT_EQ(pixel(image, 120, 2), background);
  EXPECT_EQ(pixel(image, 120 - 46, 90 - 27), background);
  EXPECT_EQ(pixel(image, 120 + 46, 90 + 27), background);
  EXPECT_EQ(pixel(image, 120 - 46 - 27, 90), background);
}

TEST_F(SdfWorld, LightDirectionIsRight) {
  const Pixel front = pixel(drawn("1 0 0"), 120 - 46, 90), back = pixel(drawn("-1 0 0"), 120 - 46, 90);
  EXPECT_GT(front[0], back[0] + 50);
}

}  // namespace
}  // namespace fire3dv::test
