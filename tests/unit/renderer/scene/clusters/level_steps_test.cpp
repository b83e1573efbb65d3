// Test of the steps to levels of detail: attributes of vertices that count in errors.
#include "renderer/scene/clusters/level_steps.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace fire3dv::scene {
namespace {

TEST(UsedAttributes, TextureCoordinatesNeedTextures) {
  Scene scene;
  scene.materials.resize(3);
  scene.materials[1].clearcoat_texture.texture = 0;
  scene.materials[2].iridescence_thickness_texture.texture = 0;
  scene.materials[2].iridescence_thickness_texture.uv_set = 1;
  std::vector<std::pair<bool, bool>> used;
  for (uint32_t material = 0; material < 3; ++material) {
    Primitive primitive;
    primitive.material = material;
    const UsedAttributes attributes = used_attributes(scene, primitive);
    used.emplace_back(attributes.uv0, attributes.uv1);
  }
  EXPECT_EQ(used, (std::vector<std::pair<bool, bool>>{{false, false}, {true, false}, {false, true}}));
}

}  // namespace
}  // namespace fire3dv::scene
