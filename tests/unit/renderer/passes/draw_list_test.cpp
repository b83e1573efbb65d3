// Test of draw sorting, without a GPU.
#include "renderer/passes/resources/scene_parts.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <random>
#include <set>
#include <utility>

namespace fire3dv::passes {
namespace {

// Three materials of three alpha modes, one mesh each, nodes in random order.
scene::Scene shuffled_scene(uint32_t seed) {
  scene::Scene scene;
  for (auto mode : {scene::AlphaMode::blend, scene::AlphaMode::opaque, scene::AlphaMode::mask}) {
    for (bool double_sided : {false, true}) {
      scene::Material material;
      material.alpha_mode = mode;
      material.double_sided = double_sided;
      scene.materials.push_back(material);
      scene::Primitive primitive;
      primitive.material = static_cast<uint32_t>(scene.materials.size() - 1);
      scene.primitives.push_back(primitive);
      scene.meshes.push_back({"", static_cast<uint32_t>(scene.primitives.size() - 1), 1});
    }
  }
  std::mt19937 random(seed);
  for (int i = 0; i < 200; ++i) {
    scene::Node node;
    node.mesh = random() % static_cast<uint32_t>(scene.meshes.size());
    if (random() % 4 == 0) node.world_from_node = glm::scale(glm::mat4(1), glm::vec3(-1, 1, 1));
    if (random() % 10 == 0) node.mesh = scene::kNone;
    scene.nodes.push_back(node);
  }
  return scene;
}

std::vector<bool> mirrored_of(const scene::Scene& scene) {
  std::vector<bool> mirrored;
  for (const scene::Node& node : scene.nodes) {
    mirrored.push_back(glm::determinant(glm::mat3(node.world_from_node)) < 0);
  }
  return mirrored;
}

TEST(DrawList, PrimitivesAppearOnceInBins) {
  const scene::Scene scene = shuffled_scene(1);
  const DrawList list = DrawList::collect(scene, mirrored_of(scene));
  std::set<std::pair<uint32_t, uint32_t>> drawn;
  size_t expected = 0;
  for (const scene::Node& node : scene.nodes) expected += node.mesh != scene::kNone;
  uint32_t next = 0;
  for (const DrawBin& bin : list.bins) {
    EXPECT_EQ(bin.first_draw, next);
    next += bin.draw_count;
    for (uint32_t i = bin.first_draw; i < next; ++i) {
      const Draw& draw = list.draws[i];
      drawn.emplace(draw.node, draw.primitive);
      const scene::Material& material = scene.materials[scene.primitives[draw.primitive].material];
      EXPECT_EQ(material.alpha_mode, bin.alpha_mode);
      EXPECT_EQ(material.double_sided, bin.double_sided);
      EXPECT_EQ(glm::determinant(glm::mat3(scene.nodes[draw.node].world_from_node)) < 0, bin.mirrored);
    }
  }
  EXPECT_EQ(next, list.draws.size());
  EXPECT_EQ(drawn.size(), expected);
  EXPECT_EQ(list.draws.size(), expected);
}

TEST(DrawList, TopologiesHaveOwnBins) {
  scene::Scene scene = shuffled_scene(3);
  scene.primitives[0].topology = scene::Topology::lines;
  scene.primitives[1].topology = scene::Topology::points;
  const DrawList list = DrawList::collect(scene, mirrored_of(scene));
  std::set<scene::Topology> seen;
  for (const DrawBin& bin : list.bins) {
    seen.insert(bin.topology);
    for (uint32_t i = bin.first_draw; i < bin.first_draw + bin.draw_count; ++i)
      EXPECT_EQ(scene.primitives[list.draws[i].primitive].topology, bin.topology);
  }
  EXPECT_EQ(seen.size(), 3u);
}

TEST(DrawList, OpaqueMaskBlendOrder) {
  const scene::Scene scene = shuffled_scene(2);
  const DrawList list = DrawList::collect(scene, mirrored_of(scene));
  for (size_t i = 1; i < list.bins.size(); ++i)
    EXPECT_LE(list.bins[i - 1].alpha_mode, list.bins[i].alpha_mode);
  EXPECT_LE(list.bins.size(), 12u);  // 3 alpha modes x 2 sides x 2 windings
  for (const DrawBin& bin : list.bins) {
    for (uint32_t i = bin.first_draw + 1; i < bin.first_draw + bin.draw_count; ++i) {
      EXPECT_LE(scene.primitives[list.draws[i - 1].primitive].material,
                scene.primitives[list.draws[i].primitive].material);
    }
  }
}

}  // namespace
}  // namespace fire3dv::passes
