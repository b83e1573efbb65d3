// Test of scene merging: the merged scene contains both scenes. Replacement vertices use the file's vertex
// order.
#include <cmath>

#include "renderer/scene/derived/loaded_scene.h"

#include "renderer/scene/model/scene_edits.h"
#include "renderer/scene/model/vertices.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

// A textured quad without normals: the loader splits its vertices.
test::GltfBuilder quad_file() {
  test::GltfBuilder builder;
  const size_t positions = builder.add_positions({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  const size_t uv = builder.add_data<float>({0, 0, 1, 0, 1, 1, 0, 1}, "VEC2", test::kFloat, 2);
  const size_t material = builder.add_textured_material(test::png(4, 4, 0xff8040ff));
  const size_t mesh = builder.add_mesh({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uv}}},
                                        {"indices", builder.add_indices({0, 1, 2, 0, 2, 3})},
                                        {"material", material}});
  const size_t root = builder.add_node("quad", {{"mesh", mesh}, {"translation", {1, 0, 0}}});
  builder.add_child(root, "a/b");
  return builder;
}

LoadedScene loaded_whole(const test::GltfBuilder& builder) {
  LoadedScene whole;
  whole.scene = loaded(builder);
  whole.derived = derive(whole.scene, Levels::all);
  return whole;
}

glm::mat4 moved_by(float x) {
  glm::mat4 matrix(1);
  matrix[3].x = x;
  return matrix;
}

TEST(MergeScenes, HoldsBothAndIsRight) {
  LoadedScene merged = loaded_whole(quad_file());
  const LoadedScene base = merged, asset = loaded_whole(quad_file());
  const uint32_t added = add_node(merged.scene, "robot~1", 0, moved_by(2));
  ASSERT_TRUE(add_below(merged, asset, added).ok());
  const uint32_t again = add_node(merged.scene, "second", added, moved_by(3));
  ASSERT_TRUE(add_below(merged, asset, again).ok());

  const Result<void> right = check_scene(merged.scene);
  EXPECT_TRUE(right.ok()) << right.error().message;
  const Result<void> derived_right = check_derived(merged.scene, merged.derived);
  EXPECT_TRUE(derived_right.ok()) << derived_right.error().message;
  ASSERT_EQ(merged.scene.nodes.size(), 3 * base.scene.nodes.size() + 2);
  for (size_t n = 0; n < base.scene.nodes.size(); ++n)
    EXPECT_EQ(merged.scene.nodes[n].path, base.scene.nodes[n].path);
  EXPECT_EQ(merged.scene.nodes[added].path, "quad/robot~01");
  const Node& quad = merged.scene.nodes[again + 1];
  EXPECT_EQ(quad.name, "") << "a name of the asset must not take one of the file";
  EXPECT_EQ(quad.path, "quad/robot~01/second/quad");
  EXPECT_EQ(merged.scene.nodes[again + 2].path, "quad/robot~01/second/quad/a~1b");
  EXPECT_EQ(quad.world_from_node, moved_by(1 + 2 + 3 + 1));
  EXPECT_EQ(quad.parent, again);

  // The last copy draws the geometry of the asset.
  const Primitive& drawn = merged.scene.primitives[merged.scene.meshes[quad.mesh].first_primitive];
  const Primitive& original = asset.scene.primitives[0];
  ASSERT_EQ(drawn.index_count, original.index_count);
  for (uint32_t i = 0; i < drawn.index_count; ++i) {
    EXPECT_EQ(merged.scene.positions[drawn.first_vertex + merged.scene.indices[drawn.first_index + i]],
              asset.scene.positions[original.first_vertex + asset.scene.indices[original.first_index + i]]);
  }
  const Texture& texture =
      merged.scene.textures[merged.scene.materials[drawn.material].base_color_texture.texture];
  EXPECT_EQ(texture.image, merged.scene.images.size() - 1);
  EXPECT_EQ(merged.scene.images[texture.image].rgba8, asset.scene.images[0].rgba8);
  EXPECT_EQ(merged.scene.images[texture.image].rgba8.identity(), asset.scene.images[0].rgba8.identity())
      << "pixels are shared";
  const ClusteredGeometry& clusters = merged.derived.clusters;
  const ClusteredPrimitive& cut = clusters.primitives[merged.scene.meshes[quad.mesh].first_primitive];
  for (uint32_t v = cut.first_vertex; v < cut.first_vertex + cut.vertex_count; ++v) {
    EXPECT_GE(clusters.source_vertices[v], drawn.first_vertex);
    EXPECT_LT(clusters.source_vertices[v], drawn.first_vertex + drawn.vertex_count);
  }
  EXPECT_EQ(clusters.clusters[cut.first_cluster].first_vertex, cut.first_vertex);
}

TEST(MergeScenes, VerticesKeepTheirExtras) {
  const LoadedScene plain = loaded_whole(quad_file());
  LoadedScene colored = plain;
  colored.scene.extras.resize(colored.scene.positions.size());
  colored.scene.extras[2].color = {1, 2, 3, 4};
  colored.scene.tangents.resize(colored.scene.positions.size(), kNoTangent);
  colored.scene.tangents[2] = {0, INT16_MAX};
  for (const bool onto_plain : {false, true}) {
    LoadedScene merged = onto_plain ? plain : colored;
    const uint32_t first = static_cast<uint32_t>(merged.scene.positions.size());
    ASSERT_TRUE(
        add_below(merged, onto_plain ? colored : plain, add_node(merged.scene, "asset", 0, moved_by(0)))
            .ok());
    EXPECT_TRUE(check_scene(merged.scene).ok());
    ASSERT_EQ(merged.scene.extras.size(), merged.scene.positions.size());
    ASSERT_EQ(merged.scene.tangents.size(), merged.scene.positions.size());
    for (uint32_t v = 0; v < merged.scene.extras.size(); ++v) {
      const bool other = v == (onto_plain ? first : 0) + 2;
      EXPECT_EQ(merged.scene.extras[v], other ? colored.scene.extras[2] : VertexExtras());
      EXPECT_EQ(merged.scene.tangents[v], other ? colored.scene.tangents[2] : kNoTangent);
    }
  }
}

TEST(ReplacedVertices, CountsMatchTheFile) {
  const Scene scene = loaded(quad_file());
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(scene.primitives[0].vertex_count, 6u) << "the loader has given each corner its own";
  ASSERT_EQ(file_vertex_count(scene, mesh), 4u);
  ReplacedVertices replaced;
  replaced.positions = {{0, 0, 0}, {2, 0, 0}, {2, 0, -2}, {0, 0, -2}};  // flat, twice as large
  const PosedVertices posed = pose_vertices(scene, mesh, replaced);
  ASSERT_EQ(posed.positions.size(), 6u);
  for (uint32_t v = 0; v < 6; ++v) {
    const glm::vec3& rest = scene.positions[scene.primitives[0].first_vertex + v];
    EXPECT_EQ(posed.positions[v], glm::vec3(2 * rest.x, 0, -2 * rest.y));
    EXPECT_EQ(posed.normals[v], glm::vec3(0, 1, 0));
  }
  EXPECT_NEAR(posed.sphere.x, 1, 1e-6f);
  EXPECT_NEAR(posed.sphere.z, -1, 1e-6f);
  EXPECT_GE(posed.sphere.w, std::sqrt(2.0f));
  replaced.normals.assign(4, {0, 3, 0});
  replaced.normals[3] = {0, 0, 0};  // a zero normal
  const PosedVertices given = pose_vertices(scene, mesh, replaced);
  EXPECT_EQ(given.normals[0], glm::vec3(0, 1, 0));
  const uint32_t last = scene.primitives[0].first_vertex + 5;
  EXPECT_EQ(given.normals[5], normal_of(scene.frames[last])) << "that of the file";
  EXPECT_EQ(rest_vertices(scene, mesh).positions, scene.positions);
}

}  // namespace
}  // namespace fire3dv::scene
