// What streams add to a scene: assets from the named folder and from nowhere else, or embedded; and what is
// refused, by name.
#include "renderer/app/scene_build.h"

#include <gtest/gtest.h>

#include "tests/support/gltf_builder.h"
#include "tests/unit/loaded_scene.h"

namespace fire3dv::app {
namespace {

using test::ScratchFolder;

class SceneBuildTest : public testing::Test {
 protected:
  SceneBuildTest() {
    base_.scene = scene::loaded(test::triangle_file());
    base_.derived = scene::derive(base_.scene);
    outside_.write("outside.glb", test::triangle_file().glb());
    std::filesystem::create_directory(outside_.path() / "assets");
    folder_ = outside_.path() / "assets";
    outside_.write("assets/inside.glb", test::triangle_file().glb());
    outside_.write("assets/broken.glb", std::string_view("glTF no more"));
    std::filesystem::create_symlink(outside_.path() / "outside.glb", folder_ / "link.glb");
  }

  state::WantedNode wanted(const std::string& name, wire::NodeAdded what) {
    return {1, ++version_, name, std::make_shared<const wire::NodeAdded>(std::move(what))};
  }
  state::WantedNode from_uri(const std::string& name, const std::string& uri) {
    wire::NodeAdded what;
    what.asset_uri = uri;
    return wanted(name, what);
  }
  static SceneBuild::Built finished(SceneBuild& build, SceneBuild::Request request) {
    build.begin(std::move(request));
    std::optional<SceneBuild::Built> built;
    while (!(built = build.take())) std::this_thread::yield();
    EXPECT_TRUE(build.idle());
    return std::move(*built);
  }
  // Why the only node of a request is refused; empty: it is not.
  std::string refusal_of(AssetSettings settings, state::WantedNode node) {
    SceneBuild build(base_, std::move(settings));
    const SceneBuild::Built built = finished(build, {{std::move(node)}, {}});
    EXPECT_EQ(built.refused.size() + built.added.size(), 1u);
    return built.refused.empty() ? "" : built.refused[0].reason;
  }

  scene::LoadedScene base_;
  ScratchFolder outside_;
  std::filesystem::path folder_;
  uint64_t version_ = 0;
};

TEST_F(SceneBuildTest, FilesComeFromTheNamedFolderAlone) {
  EXPECT_EQ(refusal_of({folder_}, from_uri("n", "inside.glb")), "");
  const std::pair<const char*, const char*> refused[] = {{"../outside.glb", "leaves"},
                                                         {"/etc/passwd", "absolute"},
                                                         {"link.glb", "link"},
                                                         {"%2e%2e/outside.glb", "leaves"},
                                                         {"file:///etc/passwd", "scheme"},
                                                         {"http://example.org/a.glb", "scheme"},
                                                         {"missing.glb", "missing.glb"},
                                                         {"broken.glb", "broken.glb"}};
  for (const auto& [uri, reason] : refused) {
    const std::string found = refusal_of({folder_}, from_uri("n", uri));
    EXPECT_NE(found.find(reason), std::string::npos) << uri << ": " << found;
  }
  EXPECT_NE(refusal_of({}, from_uri("n", "inside.glb")).find("--assets"), std::string::npos);
}

TEST_F(SceneBuildTest, AnEmbeddedAssetNamesNoFiles) {
  wire::NodeAdded what;
  what.asset_glb = test::triangle_file().glb();
  EXPECT_EQ(refusal_of({}, wanted("n", what)), "");
  test::GltfBuilder other = test::triangle_file();
  other.root["images"] = nlohmann::json::array({{{"uri", "../secret.png"}}});
  other.root["textures"] = nlohmann::json::array({{{"source", 0}}});
  other.root["materials"] =
      nlohmann::json::array({{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
  other.root["meshes"][0]["primitives"][0]["material"] = 0;
  what.asset_glb = other.glb();
  EXPECT_NE(refusal_of({folder_}, wanted("n", what)).find("embedded"), std::string::npos);
  what.asset_glb.resize(20);
  EXPECT_NE(refusal_of({folder_}, wanted("n", what)), "");
}

TEST_F(SceneBuildTest, ParentsMayBeAddedTooInAnyOrder) {
  wire::NodeAdded below;
  below.parent = "above";
  wire::NodeAdded in_asset;
  in_asset.parent = "above/" + base_.scene.nodes[0].path;  // a node of the asset, by its path
  wire::NodeAdded nowhere;
  nowhere.parent = "nobody";
  wire::NodeAdded itself;
  itself.parent = "ring";
  SceneBuild build(base_, {folder_});
  const std::string own_name = base_.scene.nodes[0].name;
  const SceneBuild::Built built = finished(
      build,
      {{wanted("below", below), wanted("deep", in_asset), wanted("lost", nowhere), wanted("ring", itself),
        from_uri("above", "inside.glb"), wanted("above", {}), wanted(own_name, {})},
       {}});
  ASSERT_EQ(built.added.size(), 3u);
  ASSERT_EQ(built.refused.size(), 4u);
  for (const SceneBuild::Refused& refused : built.refused) {
    const std::string& name = refused.node.name;
    const bool no_parent = name == "lost" || name == "ring";
    EXPECT_NE(refused.reason.find(no_parent ? "parent" : "already"), std::string::npos)
        << name << ": " << refused.reason;
  }
  ASSERT_NE(built.scene, nullptr);
  const scene::Scene& scene = built.scene->scene;
  const auto named = [&](const char* name) {
    return std::find_if(scene.nodes.begin(), scene.nodes.end(),
                        [&](const auto& n) { return n.name == name; });
  };
  ASSERT_NE(named("below"), scene.nodes.end());
  EXPECT_EQ(scene.nodes[named("below")->parent].name, "above");
  ASSERT_NE(named("deep"), scene.nodes.end());
  EXPECT_EQ(scene.nodes[scene.nodes[named("deep")->parent].parent].name, "above");
}

TEST_F(SceneBuildTest, LimitsAndVertices) {
  test::GltfBuilder textured = test::triangle_file();
  const size_t material = textured.add_textured_material(test::png(2, 2, 0xffffffff));
  textured.root["meshes"][0]["primitives"][0]["material"] = material;
  wire::NodeAdded what;
  what.asset_glb = textured.glb();
  AssetSettings settings;
  settings.most_textures = 0;
  EXPECT_NE(refusal_of(settings, wanted("n", what)).find("textures"), std::string::npos);

  SceneBuild build(base_, {});
  const std::string name = base_.scene.nodes[0].name;
  SceneBuild::Built built = finished(build, {{}, {name, "nobody"}});
  ASSERT_NE(built.scene, nullptr);
  EXPECT_TRUE(built.scene->scene.nodes[0].own_vertices);
  built = finished(build, {});
  EXPECT_EQ(built.scene, nullptr) << "the file's own";
}

}  // namespace
}  // namespace fire3dv::app
