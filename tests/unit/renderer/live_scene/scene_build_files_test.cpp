// Test of changed files of added assets: when they are read again, and when a damaged one is not.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "renderer/live_scene/scene_build.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::app {
namespace {

class SceneBuildFiles : public testing::Test {
 protected:
  SceneBuildFiles() {
    base_.scene = scene::loaded(test::triangle_file());
    base_.derived = scene::derive(base_.scene);
    AssetSettings settings;
    settings.overlay = folder_.path() / "scene.overlay.json";
    build_.emplace(base_, settings);
  }

  // With the user's addition of this file.
  SceneBuild::Built build(const std::string& uri) {
    auto addition = std::make_shared<state::Addition>();
    addition->content = state::AddedAsset{uri};
    auto added = std::make_shared<wire::NodeAdded>();
    added->asset_uri = uri;
    state::RequestedNode node{1, 1, "part", std::move(added)};
    node.addition = std::move(addition);
    build_->begin({{std::move(node)}, {}});
    std::optional<SceneBuild::Built> built;
    while (!(built = build_->take())) std::this_thread::yield();
    return std::move(*built);
  }
  static std::string last_path(const SceneBuild::Built& built) {
    return built.scene ? built.scene->scene.nodes.back().path : "";
  }
  static test::GltfBuilder with_node(const std::string& name) {
    test::GltfBuilder builder = test::triangle_file();
    builder.add_node(name);
    return builder;
  }

  test::ScratchFolder folder_;
  scene::LoadedScene base_;
  std::optional<SceneBuild> build_;
};

TEST_F(SceneBuildFiles, ReloadReadsChanges) {
  folder_.write("part.glb", with_node("old").glb());
  SceneBuild::Built built = build("part.glb");
  EXPECT_EQ(last_path(built), "part/old");
  const Digest before = built.assets.begin()->second.digest;
  EXPECT_EQ(before, digest_of_file(folder_.path() / "part.glb", 1 << 20).value());
  build_->reload(base_);
  built = build("part.glb");
  EXPECT_TRUE(built.load_ns.empty()) << "it has not changed";
  folder_.write("part.glb", with_node("new one").glb());
  built = build("part.glb");
  EXPECT_EQ(last_path(built), "part/old") << "other additions do not change it";
  EXPECT_EQ(built.assets.begin()->second.digest, before);
  build_->reload(base_);
  built = build("part.glb");
  EXPECT_EQ(last_path(built), "part/new one");
  EXPECT_NE(built.assets.begin()->second.digest, before);
  // A buffer of the file.
  test::GltfBuilder builder = with_node("end");
  folder_.write("part.bin", builder.bin);
  folder_.write("part.gltf", builder.gltf("part.bin"));
  EXPECT_EQ(last_path(build("part.gltf")), "part/end");
  builder.bin[0] ^= std::byte{1};
  folder_.write("part.bin", builder.bin);
  build_->reload(base_);
  EXPECT_FALSE(build("part.gltf").load_ns.empty());
}

TEST_F(SceneBuildFiles, DamagedFileIsRetriedOnChange) {
  folder_.write("part.glb", std::string_view("glTF no more"));
  SceneBuild::Built built = build("part.glb");
  ASSERT_EQ(built.refused.size(), 1u);
  const std::string reason = built.refused[0].reason;
  EXPECT_NE(reason.find("part.glb"), std::string::npos);
  EXPECT_FALSE(built.load_ns.empty());
  built = build("part.glb");
  ASSERT_EQ(built.refused.size(), 1u);
  EXPECT_EQ(built.refused[0].reason, reason);
  EXPECT_TRUE(built.load_ns.empty());
  folder_.write("part.glb", with_node("end").glb());
  EXPECT_EQ(last_path(build("part.glb")), "part/end");
  // A file that is not there may come at any time, and so may one that an asset names.
  test::GltfBuilder builder = with_node("end");
  EXPECT_EQ(build("later.gltf").refused.size(), 1u);
  folder_.write("later.gltf", builder.gltf("later.bin"));
  EXPECT_EQ(build("later.gltf").refused.size(), 1u);
  folder_.write("later.bin", builder.bin);
  EXPECT_EQ(last_path(build("later.gltf")), "part/end");
}

}  // namespace
}  // namespace fire3dv::app
