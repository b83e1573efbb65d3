// Test of background scene builds for added nodes: assets from the configured folder only, or embedded;
// refusals by name, and budgets per peer.
#include "renderer/live_scene/scene_build.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

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

  state::RequestedNode wanted(const std::string& name, wire::NodeAdded what) {
    return {1, ++version_, name, std::make_shared<const wire::NodeAdded>(std::move(what))};
  }
  state::RequestedNode from_uri(const std::string& name, const std::string& uri) {
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
  // Returns the refusal of a request's only node; empty if it is accepted.
  std::string refusal_of(AssetSettings settings, state::RequestedNode node) {
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

TEST_F(SceneBuildTest, FilesStayInFolder) {
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
  state::RequestedNode node = from_uri("n", "inside.glb");
  const state::Addition of_user{{}, {}, state::AddedAsset{"inside.glb"}};
  node.addition = std::make_shared<const state::Addition>(of_user);
  SceneBuild build(base_, {folder_});
  const MergedAsset asset = finished(build, {{node}, {}}).assets.at(1);
  EXPECT_EQ(asset.file, std::filesystem::canonical(folder_ / "inside.glb"));
  EXPECT_EQ(asset.first_material, base_.scene.materials.size());
}

TEST_F(SceneBuildTest, EmbeddedAssetReadsNothing) {
  wire::NodeAdded what;
  what.asset_glb = test::triangle_file().glb();
  EXPECT_EQ(refusal_of({}, wanted("n", what)), "");
  test::GltfBuilder other = test::triangle_file();
  outside_.write("folder/secret.png", test::png(3, 3, 0xffffffff));
  other.root["images"] = nlohmann::json::array({{{"uri", "secret.png"}}});
  other.root["textures"] = nlohmann::json::array({{{"source", 0}}});
  other.root["materials"] =
      nlohmann::json::array({{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
  other.root["meshes"][0]["primitives"][0]["material"] = 0;
  what.asset_glb = other.glb();
  SceneBuild build(base_, {folder_});
  const SceneBuild::Built built = finished(build, {{wanted("n", what)}, {}});
  ASSERT_TRUE(built.scene);
  const MergedAsset& merged = built.assets.at(built.roots.at(0));
  EXPECT_EQ(merged.first_material, base_.scene.materials.size());
  EXPECT_EQ(merged.first_material + merged.material_count, built.scene->scene.materials.size());
  ASSERT_FALSE(built.scene->scene.images.empty());
  EXPECT_EQ(built.scene->scene.images.back().width, 64u) << "a placeholder";
  ASSERT_EQ(built.asset_warnings.size(), 1u);
  EXPECT_TRUE(
      built.asset_warnings[0].starts_with("node \"n\": the embedded asset: images[0] \"secret.png\": "))
      << built.asset_warnings[0];

  other.root["buffers"] = nlohmann::json::array({{{"byteLength", 1}, {"uri", "inside.glb"}}});
  what.asset_glb = other.glb();
  EXPECT_NE(refusal_of({folder_}, wanted("n", what)).find("embedded"), std::string::npos);
  what.asset_glb.resize(20);
  EXPECT_NE(refusal_of({folder_}, wanted("n", what)), "");
}

TEST_F(SceneBuildTest, NodesHaveOwnVariants) {
  test::GltfBuilder car = test::triangle_file();
  car.root["materials"] = {{{"name", "grey"}}, {{"name", "red"}}};
  car.root["extensionsUsed"] = {"KHR_materials_variants"};
  car.root["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "festive"}}};
  nlohmann::json& primitive = car.root["meshes"][0]["primitives"][0];
  primitive["material"] = 0;
  primitive["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 1}, {"variants", {0}}}};
  outside_.write("assets/car.glb", car.glb());
  const auto in_variant = [&](const std::string& node, const std::string& variant, bool is_embedded) {
    wire::NodeAdded what;
    if (is_embedded)
      what.asset_glb = car.glb();
    else
      what.asset_uri = "car.glb";
    what.variant = variant;
    return wanted(node, what);
  };
  SceneBuild build(base_, {folder_});
  const SceneBuild::Built built =
      finished(build, {{in_variant("plain", "", false), in_variant("festive", "festive", false),
                        in_variant("embedded", "festive", true), in_variant("unknown", "gloomy", false)},
                       {}});
  ASSERT_TRUE(built.scene);
  const scene::Scene& scene = built.scene->scene;
  std::map<std::string, std::string> material_of;
  for (size_t i = 0; i < built.added.size(); ++i) {
    const auto below = std::find_if(scene.nodes.begin(), scene.nodes.end(),
                                    [&](const scene::Node& node) { return node.parent == built.roots[i]; });
    ASSERT_NE(below, scene.nodes.end());
    const scene::Mesh& mesh = scene.meshes[below->mesh];
    material_of[built.added[i].name] = scene.materials[scene.primitives[mesh.first_primitive].material].name;
  }
  EXPECT_EQ(material_of,
            (std::map<std::string, std::string>{{"plain", "grey"}, {"festive", "red"}, {"embedded", "red"}}));
  ASSERT_EQ(built.refused.size(), 1u);
  EXPECT_EQ(built.refused[0].reason,
            "the asset \"car.glb\": there is no material variant \"gloomy\"; there is \"festive\"");
}

TEST_F(SceneBuildTest, ParentsMayFollow) {
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

// A chain of copies in reverse order of their names, of nodes of the file and of added ones.
TEST_F(SceneBuildTest, UserAdditionsAreBuilt) {
  base_.scene.nodes[0].semantic = 7;
  const std::string file_node = base_.scene.nodes[0].path;
  const uint32_t below_it = scene::add_node(base_.scene, "below", 0, glm::mat4(1));
  base_.scene.nodes[below_it].mesh = base_.scene.nodes[0].mesh;
  const auto by_user = [&](const std::string& name, const std::string& parent, auto content) {
    state::Addition addition;
    addition.parent = parent;
    addition.transform.translation = {1, 2, 3};
    addition.content = std::move(content);
    wire::NodeAdded added;
    added.parent = parent;
    added.parent_from_node.m[3] = 1;
    state::RequestedNode node = wanted(name, added);
    node.addition = std::make_shared<const state::Addition>(addition);
    return node;
  };
  using Copy = state::CopiedNode;
  scene::Light light;
  light.intensity = 5;
  scene::Camera camera;
  camera.vertical_fov_rad = 0.5f;
  SceneBuild build(base_, {});
  const SceneBuild::Built built =
      finished(build, {{by_user("a", "", Copy{"b/below"}), by_user("b", "", Copy{file_node}),
                        by_user("lamp", file_node, light), by_user("view", "", camera),
                        by_user("ring", "", Copy{"gnir"}), by_user("gnir", "", Copy{"ring"}),
                        by_user("lost", "", Copy{"nobody"}), by_user("itself", file_node, Copy{file_node})},
                       {}});
  ASSERT_NE(built.scene, nullptr);
  const scene::Scene& scene = built.scene->scene;
  std::map<std::string, uint32_t> nodes;
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) nodes[scene.nodes[node].path] = node;
  EXPECT_EQ(nodes.size(), scene.nodes.size());
  const uint32_t mesh = scene.nodes[0].mesh;
  ASSERT_TRUE(nodes.contains("b/below") && nodes.contains("a") && nodes.contains("view"));
  EXPECT_EQ(scene.nodes[nodes["a"]].mesh, mesh);
  EXPECT_EQ(scene.nodes[nodes["b/below"]].mesh, mesh) << "by reference";
  EXPECT_EQ(scene.nodes[nodes["b"]].semantic, 7u);
  EXPECT_EQ(scene.nodes[nodes["b/below"]].world_from_node[3][0], 1);
  EXPECT_EQ(scene.nodes[nodes["b/below"]].name, "") << "names stay those of the file's nodes";
  EXPECT_EQ(scene.meshes.size(), base_.scene.meshes.size());
  EXPECT_EQ(scene.lights.at(scene.nodes[nodes[file_node + "/lamp"]].light).intensity, 5);
  EXPECT_EQ(scene.cameras.at(scene.nodes[nodes["view"]].camera).vertical_fov_rad, 0.5f);
  EXPECT_FALSE(nodes.contains("b/lamp")) << "copies leave other additions out";
  EXPECT_EQ(built.sources.at(nodes["b"]), (std::vector<uint32_t>{0, below_it}));
  EXPECT_TRUE(nodes.contains(file_node + "/itself/below"));
  EXPECT_FALSE(nodes.contains(file_node + "/itself/itself"));
  ASSERT_EQ(built.refused.size(), 3u);
  for (const SceneBuild::Refused& refused : built.refused)
    EXPECT_NE(refused.reason.find("which it copies"), std::string::npos) << refused.reason;
}

// Copies of copies do not double the scene each time.
TEST_F(SceneBuildTest, CopiesExcludeAdditions) {
  std::vector<state::RequestedNode> nodes;
  std::vector<std::string> paths{base_.scene.nodes[0].path};
  for (size_t i = 0; i < 40; ++i) {
    state::Addition addition;
    addition.parent = paths.back();
    addition.content = state::CopiedNode{paths[i < 2 ? 0 : i - 1]};
    paths.push_back(paths.back() + "/c" + std::to_string(i));
    wire::NodeAdded added;
    added.parent = addition.parent;
    nodes.push_back(wanted("c" + std::to_string(i), added));
    nodes.back().addition = std::make_shared<const state::Addition>(addition);
  }
  SceneBuild build(base_, {});
  const SceneBuild::Built built = finished(build, {std::move(nodes), {}});
  EXPECT_EQ(built.added.size(), 40u);
  EXPECT_EQ(built.scene->scene.nodes.size(), base_.scene.nodes.size() + 40);
}

TEST_F(SceneBuildTest, LimitsAndVertices) {
  test::GltfBuilder textured = test::triangle_file();
  const size_t material = textured.add_textured_material(test::png(2, 2, 0xffffffff));
  textured.root["meshes"][0]["primitives"][0]["material"] = material;
  wire::NodeAdded what;
  what.asset_glb = textured.glb();
  AssetSettings settings;
  settings.max_textures = 0;
  EXPECT_NE(refusal_of(settings, wanted("n", what)).find("textures"), std::string::npos);

  SceneBuild build(base_, {});
  const std::string name = base_.scene.nodes[0].name;
  SceneBuild::Built built = finished(build, {{}, {{name}, {"nobody"}}});
  ASSERT_NE(built.scene, nullptr);
  EXPECT_TRUE(built.scene->scene.nodes[0].has_instance_vertices);
  built = finished(build, {});
  EXPECT_EQ(built.scene, nullptr) << "the file's own";
}

// A chain of nodes in reverse order: one lookup each, and one more after the parent's arrival.
TEST_F(SceneBuildTest, ParentLookUpIsLinear) {
  const auto lookups = [&](int length) {
    std::vector<state::RequestedNode> nodes;
    for (int i = length; i-- > 0;) {
      wire::NodeAdded what;
      if (i > 0) what.parent = "n" + std::to_string(i - 1);
      nodes.push_back(wanted("n" + std::to_string(i), what));
    }
    SceneBuild build(base_, {});
    const SceneBuild::Built built = finished(build, {std::move(nodes), {}});
    EXPECT_EQ(built.added.size(), static_cast<size_t>(length));
    return built.parent_lookups;
  };
  EXPECT_LE(lookups(100), 200u);
  EXPECT_LE(lookups(400), 800u);
}

TEST_F(SceneBuildTest, ExistingPathsAreKept) {
  wire::NodeAdded below;
  below.parent = "n";
  SceneBuild build(base_, {folder_});
  const std::string of_asset = base_.scene.nodes[0].path;  // the same path as in the asset
  const SceneBuild::Built built = finished(build, {{from_uri("n", "inside.glb"), wanted("m", {}),
                                                    wanted(of_asset + "x", below), wanted(of_asset, below)},
                                                   {}});
  EXPECT_EQ(built.added.size(), 3u);
  ASSERT_EQ(built.refused.size(), 1u);
  EXPECT_EQ(built.refused[0].node.name, of_asset);
}

class SceneBuildBudget : public SceneBuildTest {
 protected:
  std::shared_ptr<PeerBudget> peer(std::initializer_list<const char*> limits = {}) {
    PeerLimits all;
    for (const char* limit : limits) EXPECT_TRUE(set_limit(limit, all).ok());
    pools_.push_back(BudgetPool::create(all));
    return pools_.back()->add_peer("peer");
  }
  static state::RequestedNode of(state::RequestedNode node, std::shared_ptr<PeerBudget> budget) {
    node.budget = std::move(budget);
    return node;
  }
  std::vector<std::shared_ptr<BudgetPool>> pools_;
};

TEST_F(SceneBuildBudget, NodesAreChargedAndRefunded) {
  const auto budget = peer({"nodes=5"});
  SceneBuild build(base_, {folder_});
  std::vector<state::RequestedNode> nodes;
  for (const char* name : {"a", "b", "c", "d", "e", "f"}) nodes.push_back(of(wanted(name, {}), budget));
  SceneBuild::Built built = finished(build, {nodes, {}});
  EXPECT_EQ(built.added.size(), 5u);
  ASSERT_EQ(built.refused.size(), 1u);
  EXPECT_NE(built.refused[0].reason.find("--peer-limit nodes="), std::string::npos);
  EXPECT_EQ(budget->used(Resource::nodes), 5u);
  // A build with the same nodes charges nothing more; one with fewer nodes returns the difference.
  nodes.resize(2);
  built = finished(build, {nodes, {}});
  EXPECT_EQ(built.added.size(), 2u);
  EXPECT_EQ(budget->used(Resource::nodes), 2u);
  built = finished(build, {{of(from_uri("g", "inside.glb"), budget)}, {}});
  EXPECT_EQ(budget->used(Resource::nodes), 1 + base_.scene.nodes.size());
  built = finished(build, {});
  EXPECT_EQ(budget->used(Resource::nodes), 0u);
  EXPECT_EQ(budget->used(Resource::asset_bytes), 0u);
  EXPECT_EQ(budget->used(Resource::gpu_bytes), 0u);
}

TEST_F(SceneBuildBudget, AssetCountsPerPeer) {
  const auto one = peer(), other = peer();
  SceneBuild build(base_, {folder_});
  (void)finished(build, {{of(from_uri("a", "inside.glb"), one)}, {}});
  const uint64_t asset = one->used(Resource::asset_bytes), gpu = one->used(Resource::gpu_bytes);
  EXPECT_GT(asset, 0u);
  EXPECT_GT(gpu, 0u);
  const auto a = of(from_uri("a", "inside.glb"), one), b = of(from_uri("b", "inside.glb"), one),
             c = of(from_uri("c", "inside.glb"), other);
  (void)finished(build, {{a, b, c}, {}});
  const uint64_t paths = one->used(Resource::asset_bytes) - asset;
  EXPECT_LT(paths, 200u) << "of the second node";
  EXPECT_EQ(other->used(Resource::asset_bytes), asset);
  EXPECT_EQ(one->used(Resource::gpu_bytes), 2 * gpu) << "the scene holds the geometry of each node";
}

// 4 MiB of decoded pixels in a file of some KB.
TEST_F(SceneBuildBudget, PixelsAreChargedBeforeDecoding) {
  test::GltfBuilder textured = test::triangle_file();
  const size_t material = textured.add_textured_material(test::png(1024, 1024, 0xffffffff));
  textured.root["meshes"][0]["primitives"][0]["material"] = material;
  wire::NodeAdded what;
  what.asset_glb = textured.glb();
  const auto poor = peer({"asset-bytes=4MiB"}), rich = peer({"asset-bytes=8MiB"});
  SceneBuild build(base_, {});
  SceneBuild::Built built = finished(build, {{of(wanted("n", what), poor)}, {}});
  ASSERT_EQ(built.refused.size(), 1u);
  EXPECT_NE(built.refused[0].reason.find("1048576 pixels"), std::string::npos) << built.refused[0].reason;
  EXPECT_NE(built.refused[0].reason.find("--peer-limit asset-bytes="), std::string::npos);
  EXPECT_EQ(poor->used(Resource::asset_bytes), 0u);
  built = finished(build, {{of(wanted("n", what), rich)}, {}});
  EXPECT_EQ(built.added.size(), 1u);
  EXPECT_GE(rich->used(Resource::asset_bytes), uint64_t{4} << 20);
}

TEST_F(SceneBuildBudget, PathsAreBytes) {
  const auto budget = peer({"asset-bytes=16MiB"});
  std::vector<state::RequestedNode> nodes;
  const auto name_of = [](int level) { return std::string(1000, 'x') + std::to_string(level); };
  for (int level = 0; level < 100; ++level) {
    wire::NodeAdded what;
    if (level > 0) what.parent = name_of(level - 1);
    nodes.push_back(of(wanted(name_of(level), what), budget));
  }
  for (int leaf = 0; leaf < 100; ++leaf) {
    wire::NodeAdded what;
    what.parent = name_of(99);
    nodes.push_back(of(wanted("leaf" + std::to_string(leaf), what), budget));
  }
  SceneBuild build(base_, {});
  const SceneBuild::Built built = finished(build, {nodes, {}});
  EXPECT_GT(built.refused.size(), 50u);
  uint64_t bytes = 0;
  for (const scene::Node& node : built.scene->scene.nodes) bytes += node.path.size();
  EXPECT_LE(bytes, uint64_t{16} << 20);
  EXPECT_LE(budget->used(Resource::asset_bytes), uint64_t{16} << 20);
}

// A peer with many slow assets and one with a small asset alternate.
TEST_F(SceneBuildBudget, PeersAlternateLoading) {
  const auto greedy = peer(), small = peer();
  std::string order;
  int64_t now_ns = 0;
  AssetSettings settings;
  settings.now_ns = [&] { return now_ns; };
  settings.load = [&](const state::RequestedNode& node, const scene::LoadLimits&) -> Result<scene::Scene> {
    order += node.name + " ";
    now_ns += node.name[0] == 'g' ? 5'000'000'000 : 1'000'000;
    return scene::Scene(base_.scene);
  };
  SceneBuild build(base_, settings);
  std::vector<state::RequestedNode> nodes;
  for (const char* name : {"g1", "g2", "g3", "g4"}) nodes.push_back(of(from_uri(name, name), greedy));
  SceneBuild::Built built = finished(build, {nodes, {}});
  EXPECT_EQ(order, "g1 ") << "one asset, since it took longer than a turn";
  EXPECT_EQ(built.added.size(), 1u);
  EXPECT_TRUE(built.assets_wait);
  EXPECT_TRUE(built.refused.empty()) << "the others wait";
  // The other peer requests its assets in the meantime.
  for (const char* name : {"s1", "s2"}) nodes.push_back(of(from_uri(name, name), small));
  built = finished(build, {nodes, {}});
  EXPECT_EQ(order, "g1 s1 s2 ");
  EXPECT_EQ(built.added.size(), 3u);
  for (int turn = 0; built.assets_wait; ++turn) {
    ASSERT_LT(turn, 5);
    built = finished(build, {nodes, {}});
  }
  EXPECT_EQ(order, "g1 s1 s2 g2 g3 g4 ");
  EXPECT_EQ(built.added.size(), 6u);
  EXPECT_GT(greedy->build_ns(), small->build_ns());
  // No asset is loaded twice.
  (void)finished(build, {nodes, {}});
  EXPECT_EQ(order, "g1 s1 s2 g2 g3 g4 ");
}

TEST_F(SceneBuildBudget, WaitingPeersAlternate) {
  const auto one = peer(), other = peer();
  std::string order;
  int64_t now_ns = 0;
  AssetSettings settings;
  settings.now_ns = [&] { return now_ns; };
  settings.load = [&](const state::RequestedNode& node, const scene::LoadLimits&) -> Result<scene::Scene> {
    order += node.name + " ";
    now_ns += 1'000'000'000;
    return scene::Scene(base_.scene);
  };
  SceneBuild build(base_, settings);
  std::vector<state::RequestedNode> nodes;
  for (const char* name : {"a1", "a2", "a3"}) nodes.push_back(of(from_uri(name, name), one));
  for (const char* name : {"b1", "b2", "b3"}) nodes.push_back(of(from_uri(name, name), other));
  for (int turn = 0; turn < 6; ++turn) (void)finished(build, {nodes, {}});
  EXPECT_EQ(order, "a1 b1 a2 b2 a3 b3 ");
}

TEST_F(SceneBuildBudget, LightsBeyondLimitAreRefused) {
  test::GltfBuilder lit = test::triangle_file();
  lit.root["extensionsUsed"] = {"KHR_lights_punctual"};
  lit.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  lit.root["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  wire::NodeAdded what;
  what.asset_glb = lit.glb();
  const auto budget = peer({"lights=2", "shadow-lights=1"});
  SceneBuild build(base_, {});
  const SceneBuild::Built built = finished(
      build,
      {{of(wanted("a", what), budget), of(wanted("b", what), budget), of(wanted("c", what), budget)}, {}});
  ASSERT_EQ(built.refused.size(), 1u);
  EXPECT_EQ(built.refused[0].node.name, "c");
  EXPECT_NE(built.refused[0].reason.find("--peer-limit lights="), std::string::npos);
  const std::vector<scene::Light>& lights = built.scene->scene.lights;
  ASSERT_EQ(lights.size(), base_.scene.lights.size() + 2);
  EXPECT_TRUE(lights[lights.size() - 2].casts_shadow);
  EXPECT_FALSE(lights.back().casts_shadow);
}

TEST_F(SceneBuildBudget, VerticesTakeDeviceMemory) {
  const auto poor = peer({"gpu-bytes=16"}), rich = peer();
  const std::string name = base_.scene.nodes[0].name;
  SceneBuild build(base_, {});
  SceneBuild::Built built = finished(build, {{}, {{name, poor}}});
  EXPECT_FALSE(built.scene->scene.nodes[0].has_instance_vertices);
  EXPECT_NE(built.vertex_refusals[name].find("gpu-bytes"), std::string::npos);
  built = finished(build, {{}, {{name, rich}}});
  EXPECT_TRUE(built.scene->scene.nodes[0].has_instance_vertices);
  EXPECT_GT(rich->used(Resource::gpu_bytes), 0u);
  built = finished(build, {});
  EXPECT_EQ(rich->used(Resource::gpu_bytes), 0u);
}

}  // namespace
}  // namespace fire3dv::app
