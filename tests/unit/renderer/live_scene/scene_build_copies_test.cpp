// Test of limits of the user's copies in a scene build: paths, memory, deformed vertices.
#include <gtest/gtest.h>

#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "renderer/live_scene/scene_build.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::app {
namespace {

class SceneBuildCopies : public testing::Test {
 protected:
  SceneBuildCopies() {
    base_.scene = scene::loaded(test::triangle_file());
    base_.derived = scene::derive(base_.scene);
    base_.scene.nodes[0].name = base_.scene.nodes[0].path = kTop;
  }

  state::RequestedNode copy_of(const std::string& path, const char* name, const std::string& parent = "") {
    auto addition = std::make_shared<state::Addition>();
    addition->parent = parent;
    addition->content = state::CopiedNode{path};
    auto added = std::make_shared<wire::NodeAdded>();
    added->parent = parent;
    state::RequestedNode node{1, ++version_, name, std::move(added)};
    node.addition = std::move(addition);
    return node;
  }
  // Copies of the top node.
  SceneBuild::Built build(std::initializer_list<const char*> names, AssetSettings settings = {}) {
    SceneBuild::Request request;
    for (const char* const name : names) request.nodes.push_back(copy_of(kTop, name));
    return build(std::move(request), std::move(settings));
  }
  SceneBuild::Built build(SceneBuild::Request request, AssetSettings settings = {}) {
    SceneBuild build(base_, std::move(settings));
    build.begin(std::move(request));
    std::optional<SceneBuild::Built> built;
    while (!(built = build.take())) std::this_thread::yield();
    return std::move(*built);
  }
  uint32_t add_instance() {
    const uint32_t instance = scene::add_node(base_.scene, "", 0, glm::mat4(1));
    base_.scene.nodes[instance].path.clear();
    return instance;
  }

  static constexpr const char* kTop = "a top node with a long name";
  scene::LoadedScene base_;
  uint64_t version_ = 0;
};

TEST_F(SceneBuildCopies, InstancesHaveNoPaths) {
  for (int i = 0; i < 3; ++i) (void)add_instance();
  const uint32_t leaf = scene::add_node(base_.scene, "leaf", 0, glm::mat4(1));
  const SceneBuild::Built built = build({"c"});
  ASSERT_TRUE(built.refused.empty()) << built.refused[0].reason;
  const scene::Scene& scene = built.scene->scene;
  ASSERT_EQ(scene.nodes.size(), 10u);
  const std::vector<uint32_t>& sources = built.sources.at(5);
  EXPECT_EQ(sources, (std::vector<uint32_t>{0, 1, 2, 3, leaf}));
  uint64_t bytes = 0;
  for (size_t node = 5; node < scene.nodes.size(); ++node) bytes += scene.nodes[node].path.size();
  EXPECT_EQ(bytes, std::string("c"
                               "c/leaf")
                       .size());
  EXPECT_EQ(scene::path_bytes_of_copy(base_.scene, sources, "c"), bytes);
}

TEST_F(SceneBuildCopies, TakeMemoryWithAssets) {
  scene::Scene& scene = base_.scene;
  scene.nodes[0].morph_weight_count = 1000;
  scene.morph_weights.resize(1000);
  const uint32_t joint = scene::add_node(scene, "joint", 0, glm::mat4(1));
  const uint32_t outside = scene::add_node(scene, "outside", scene::kNone, glm::mat4(1));
  scene.joints.assign(2000, {joint, glm::mat4(1)});
  scene.skins.push_back({"whole", 0, 2000});
  scene.joints.push_back({outside, glm::mat4(1)});
  scene.skins.push_back({"in part", 2000, 1});
  scene.nodes[0].skin = 0;
  const uint32_t other = scene::add_node(scene, "other", 0, glm::mat4(1));
  scene.nodes[other].mesh = scene.nodes[0].mesh;
  scene.nodes[other].skin = 1;
  const scene::CopyPlan plan = scene::plan_copy(scene, {0, joint, other});
  EXPECT_EQ(plan.own_skins, (std::vector<uint32_t>{0}));
  EXPECT_EQ(plan.joints, 2000u);
  EXPECT_GE(plan.host_bytes, 2000 * sizeof(scene::Joint) + 1000 * sizeof(float) + 3 * sizeof(scene::Node));

  AssetSettings settings;
  settings.max_added_bytes = 2 * plan.host_bytes;
  const SceneBuild::Built built = build({"c1", "c2", "c3"}, settings);
  EXPECT_EQ(built.added.size(), 2u);
  ASSERT_EQ(built.refused.size(), 1u);
  EXPECT_EQ(built.refused[0].node.name, "c3");
  EXPECT_NE(built.refused[0].reason.find("assets and copies together"), std::string::npos)
      << built.refused[0].reason;
  const scene::Scene& merged = built.scene->scene;
  EXPECT_EQ(merged.joints.size(), scene.joints.size() + 2 * plan.joints);
  EXPECT_EQ(merged.morph_weights.size(), 3000u);
  const uint32_t root = built.roots[0];
  EXPECT_EQ(merged.nodes[root].skin, 2u);
  EXPECT_EQ(merged.joints[merged.skins[2].first_joint].node, root + 1);
  EXPECT_EQ(merged.nodes[root + 2].skin, 1u) << "its joint is outside";
}

TEST_F(SceneBuildCopies, DeformedVerticesCountWithCopies) {
  scene::Scene& scene = base_.scene;
  scene.nodes[0].morph_weight_count = 1;
  scene.morph_weights = {0.5f};
  const scene::Mesh& mesh = scene.meshes[scene.nodes[0].mesh];
  scene.primitives[mesh.first_primitive].index_count = scene::kMaxDeformedCorners / 4;
  const SceneBuild::Built built = build({"c1", "c2", "c3", "c4"});
  EXPECT_EQ(built.added.size(), 3u);
  ASSERT_EQ(built.refused.size(), 1u);
  EXPECT_NE(built.refused[0].reason.find("deformed vertices"), std::string::npos) << built.refused[0].reason;
  EXPECT_EQ(scene::deformed_corners(built.scene->scene), scene::kMaxDeformedCorners);
}

TEST_F(SceneBuildCopies, CopiesAreByPath) {
  scene::add_node(base_.scene, "leaf", 0, glm::mat4(1));
  const std::string leaf = std::string(kTop) + "/leaf";
  const SceneBuild::Built built =
      build({{copy_of("leaf", "by name"), copy_of(kTop, "below a name", "leaf"), copy_of("", "in", leaf),
              copy_of(leaf, "by path"), copy_of(kTop, "below it", "by path"), copy_of("in", "by added name"),
              copy_of("in", "waits for a path"), copy_of(leaf, "in/x"), copy_of("in~1x", "of it")},
             {}});
  std::map<std::string, std::string> refused;
  for (const SceneBuild::Refused& each : built.refused) refused[each.node.name] = each.reason;
  EXPECT_EQ(refused.size(), 4u);
  EXPECT_EQ(refused["by name"],
            "no node has the path \"leaf\", which it copies; write \"a top node with a long name/leaf\"");
  EXPECT_EQ(refused["below a name"],
            "no node has the path \"leaf\", its parent; write \"a top node with a long name/leaf\"");
  EXPECT_TRUE(refused.contains("by added name"));
  EXPECT_EQ(built.added.size(), 5u);
  // A name that looks like the path of another node.
  base_.scene.nodes[1].name = kTop;
  base_.scene.nodes[0].name = "other";
  const SceneBuild::Built of_path = build({"c"});
  ASSERT_EQ(of_path.sources.size(), 1u);
  EXPECT_EQ(of_path.sources.begin()->second.front(), 0u);
}

}  // namespace
}  // namespace fire3dv::app
