// Test of animation playback on a generated file and on public assets (FIRE3DV_ASSETS, or shared/assets
// beside the source tree): no deformed vertex leaves its bounds.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iostream>

#include "renderer/scene/model/bounds.h"
#include "renderer/state/motion/animation.h"
#include "tests/support/asset_collection_folder.h"
#include "tests/unit/renderer/scene/gltf/motion_file.h"

namespace fire3dv::state {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using scene::kNone;

fs::path assets() {
  return test::asset_collection_folder();
}

// Returns a vertex in world space, by the formulas of the glTF specification.
glm::vec3 deformed(const scene::Scene& scene, const RestPose& pose, uint32_t n,
                   const scene::Primitive& primitive, uint32_t vertex) {
  const scene::Node& node = scene.nodes[n];
  glm::vec3 position = scene.positions[primitive.first_vertex + vertex];
  for (uint32_t t = 0; t < primitive.morph_target_count; ++t) {
    const size_t delta = primitive.first_morph_delta + size_t{t} * primitive.vertex_count + vertex;
    position += pose.morph_weights[node.first_morph_weight + t] * scene.morph_deltas[delta].position;
  }
  if (node.skin == kNone || primitive.first_influence == kNone)
    return glm::vec3(pose.world_from_node[n] * glm::vec4(position, 1));
  const scene::Skin& skin = scene.skins[node.skin];
  glm::vec4 sum(0);
  for (uint32_t s = 0; s < primitive.influence_sets; ++s) {
    const scene::Influences& set =
        scene.influences[primitive.first_influence + size_t{vertex} * primitive.influence_sets + s];
    for (size_t i = 0; i < 4; ++i) {
      const scene::Joint& joint = scene.joints[skin.first_joint + set.joints[i]];
      sum += set.weights[i] *
             (pose.world_from_node[joint.node] * joint.joint_from_mesh * glm::vec4(position, 1));
    }
  }
  return glm::vec3(sum);
}

// Returns the number of checked vertices.
size_t expect_within_bounds(const scene::Scene& scene, const RestPose& pose, const std::string& file) {
  size_t looked_at = 0;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].mesh == kNone) continue;
    const scene::Box box = scene::bounds_in_world(scene, n, pose.world_from_node);
    const glm::vec3 slack =
        1e-5f * (glm::abs(box.low) + glm::abs(box.high));  // rounding of vertices without deformation
    const scene::Mesh& mesh = scene.meshes[scene.nodes[n].mesh];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      for (uint32_t v = 0; v < scene.primitives[p].vertex_count; ++v, ++looked_at) {
        const glm::vec3 vertex = deformed(scene, pose, n, scene.primitives[p], v);
        const bool inside = glm::all(glm::greaterThanEqual(vertex, box.low - slack)) &&
                            glm::all(glm::lessThanEqual(vertex, box.high + slack));
        if (inside) continue;
        ADD_FAILURE() << file << ": node " << n << ", vertex " << v << " is out of bounds";
        return looked_at;
      }
    }
  }
  return looked_at;
}

size_t expect_bounded_while_playing(const scene::Scene& scene, const std::string& file) {
  size_t looked_at = expect_within_bounds(scene, rest_pose(scene), file);
  for (uint32_t a = 0; a < scene.animations.size(); ++a) {
    AnimationPlayer player(scene, {a});
    constexpr int kTimes = 17;
    for (int i = 0; i < kTimes; ++i) {
      const double time = scene.animations[a].duration_s * static_cast<double>(i) / kTimes;
      looked_at += expect_within_bounds(scene, player.at(time), file);
    }
  }
  return looked_at;
}

TEST(AnimatedBounds, HoldForFileMadeHere) {
  const scene::Scene scene = test::loaded_scene(test::motion_file());
  EXPECT_GT(expect_bounded_while_playing(scene, "motion_file"), 50u);
  // The first weight reaches 1, which lifts all vertices to z = 2; the second reaches 0.5, which moves one to
  // x = 3.
  EXPECT_NEAR(scene.primitives[0].bounds_max.x, 3, 1e-3f);
  EXPECT_NEAR(scene.primitives[0].bounds_max.z, 2, 1e-3f);
  ASSERT_EQ(scene.primitives[0].joint_bounds_count, 2u);
  const scene::JointBounds& tip = scene.joint_bounds[scene.primitives[0].first_joint_bounds + 1];
  EXPECT_EQ(tip.joint, 1u);
  EXPECT_NEAR(tip.bounds_min.x, 0, 1e-3f);
  EXPECT_NEAR(tip.bounds_max.x, 3, 1e-3f);
}

TEST(AnimatedBounds, SplineOvershootIsBounded) {
  test::GltfBuilder builder = test::motion_file();
  json& sampler = builder.root["animations"][0]["samplers"][2];
  sampler["interpolation"] = "CUBICSPLINE";
  // For two targets: in-tangents, values, out-tangents at each key.
  sampler["output"] = builder.add_data<float>({0, 0, 0, 0, 0, 50, 0, -9, 0, 0, 3, 3, 0, 0, 0, 0, 0, 0},
                                              "SCALAR", test::kFloat, 1);
  const scene::Scene scene = test::loaded_scene(builder);
  AnimationPlayer player(scene, {0});
  EXPECT_GT(player.at(0.3).morph_weights[1], 4) << "no key says more than 0";
  EXPECT_GT(expect_bounded_while_playing(scene, "spline"), 50u);
}

TEST(AnimatedBounds, RestBoundsFollowPose) {
  const scene::Scene scene = test::loaded_scene(test::motion_file());
  EXPECT_LT(scene.bounds_max.x, 50)
      << "the figure's own node stands at x = 100, which has no part in a skinned mesh";
}

// Returns the duration from the input accessors of the file.
float longest_input(const fs::path& file, size_t animation) {
  const json root = json::parse(std::ifstream(file));
  float longest = 0;
  for (const json& channel : root["animations"][animation]["channels"]) {
    const json& sampler = root["animations"][animation]["samplers"][channel["sampler"].get<size_t>()];
    longest = std::max(longest, root["accessors"][sampler["input"].get<size_t>()]["max"][0].get<float>());
  }
  return longest;
}

TEST(AnimatedAssets, CollectionStaysWithinItsBounds) {
  FIRE3DV_NEEDS_ASSETS();
  const std::vector<const char*> collections{"gltf-asset-generator", "gltf-blender-io", "bevy",
                                             "khronos-sample-models"};
  size_t moving = 0, vertices = 0, durations = 0;
  for (const char* collection : collections) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(assets() / collection)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".gltf" && extension != ".glb") continue;
      const auto scene = scene::load_gltf(entry.path());
      if (!scene || (scene->animations.empty() && scene->influences.empty() && scene->morph_deltas.empty()))
        continue;
      ++moving;
      vertices += expect_bounded_while_playing(*scene, entry.path().string());
      for (size_t a = 0; a < scene->animations.size() && extension == ".gltf"; ++a) {
        if (!scene->warnings.empty()) continue;
        ++durations;
        EXPECT_FLOAT_EQ(scene->animations[a].duration_s, longest_input(entry.path(), a)) << entry.path();
      }
    }
  }
  std::cout << moving << " files that move, " << vertices << " posed vertices, " << durations
            << " durations\n";
  EXPECT_GT(moving, 30u);
  EXPECT_GT(durations, 20u);
}

// The same rotation as floats, bytes and shorts.
TEST(AnimatedAssets, CollectionsComponentTypesAgree) {
  FIRE3DV_NEEDS_ASSETS();
  const fs::path folder = assets() / "gltf-asset-generator" / "Animation_SamplerType";
  std::vector<scene::Scene> scenes;
  for (const char* file :
       {"Animation_SamplerType_00.gltf", "Animation_SamplerType_01.gltf", "Animation_SamplerType_02.gltf"}) {
    auto scene = scene::load_gltf(folder / file);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    ASSERT_EQ(scene->animations.size(), 1u);
    scenes.push_back(std::move(*scene));
  }
  std::vector<AnimationPlayer> players;
  for (const scene::Scene& scene : scenes) players.emplace_back(scene, std::vector<uint32_t>{0});
  float turned = 0;
  for (int i = 0; i < 40; ++i) {
    const double time = 0.1 * i;
    const glm::mat4 exact = players[0].at(time).world_from_node[0];
    turned = std::max(turned, std::abs(exact[0][0] - scenes[0].nodes[0].world_from_node[0][0]));
    for (const size_t other : {1, 2}) {
      for (int column = 0; column < 3; ++column) {
        for (int row = 0; row < 3; ++row) {
          EXPECT_NEAR(players[other].at(time).world_from_node[0][column][row], exact[column][row],
                      other == 1 ? 2e-2 : 1e-4)
              << time;
        }
      }
    }
  }
  EXPECT_GT(turned, 0.1f);
}

TEST(AnimatedAssets, CollectionsFoxHasThreeGaits) {
  FIRE3DV_NEEDS_ASSETS();
  const fs::path file = assets() / "bevy" / "Fox.glb";
  const auto scene = scene::load_gltf(file);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_TRUE(scene->warnings.empty());
  ASSERT_EQ(scene->animations.size(), 3u);
  EXPECT_EQ(choose_animations(*scene, "Run").value(), std::vector<uint32_t>{2});
  EXPECT_EQ(choose_animations(*scene, "all").value(), std::vector<uint32_t>{0}) << "gaits exclude each other";
  ASSERT_EQ(scene->skins.size(), 1u);
  EXPECT_EQ(scene->skins[0].joint_count, 24u);
  const scene::Primitive& primitive = scene->primitives[0];
  EXPECT_EQ(primitive.influence_sets, 1u);
  AnimationPlayer run(*scene, {2});
  const RestPose before = run.at(0.1);
  EXPECT_NE(deformed(*scene, before, 0, primitive, 0), glm::vec3(0));
  EXPECT_NE(before.world_from_node, run.at(0.4).world_from_node);
}

}  // namespace
}  // namespace fire3dv::state
