// Test of the scene cache: entries round-trip byte for byte. A damaged entry, or one with changed sources, is
// a miss and the scene is loaded again.
#include "renderer/scene/cache/scene_cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <thread>

#include "renderer/scene/cache_files.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/motion_file.h"

namespace fire3dv::scene {
namespace {

namespace fs = std::filesystem;
using test::ScratchFolder;

// All animated features, with a textured strip beside it.
test::GltfBuilder rich_file() {
  test::GltfBuilder b = test::motion_file();
  const size_t positions = b.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  const size_t uv = b.add_data<float>({0, 0, 1, 0, 0, 1, 1, 1}, "VEC2", test::kFloat, 2);
  const size_t material = b.add_textured_material(test::png(2, 2, 0xff8040ff));
  const size_t mesh = b.add_mesh({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uv}}},
                                  {"indices", b.add_indices({0, 1, 2, 3})},
                                  {"mode", 5},
                                  {"material", material}});
  b.root["extensionsUsed"] = {"KHR_lights_punctual"};
  b.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  b.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
  const size_t node = b.add_node("strip", {{"mesh", mesh}});
  b.add_child(node, "eye", {{"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  return b;
}

struct Loaded {
  LoadedScene scene;
  std::vector<SourceFile> sources;
};

Loaded load(const fs::path& path) {
  Loaded loaded;
  auto scene = load_gltf(path, {}, {}, &loaded.sources);
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  if (!scene) return loaded;
  loaded.scene.scene = std::move(*scene);
  loaded.scene.derived = derive(loaded.scene.scene, Levels::all);
  return loaded;
}

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

SceneCacheSettings in_folder(const fs::path& folder) {
  SceneCacheSettings settings;
  settings.place = SceneCacheSettings::Place::folder;
  settings.folder = folder;
  settings.least_scene_bytes = 0;
  return settings;
}

std::optional<LoadedScene> find(const SceneCacheSettings& settings, const fs::path& asset) {
  return SceneCache(settings).find(asset, LoadLimits().max_file_bytes);
}

size_t files_in(const fs::path& folder) {
  size_t count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    count += entry.is_regular_file() ? 1 : 0;
  return count;
}

// Returns the bytes of the scene written again: any different member or array changes them.
std::string written(const ScratchFolder& folder, const LoadedScene& scene) {
  EXPECT_TRUE(write_scene_file(folder.path() / "again", scene, {}).ok());
  return bytes_of(folder.path() / "again");
}

// A cached digest stands for the file until the file is written again.
TEST(SceneCache, DigestHoldsUntilFileChanges) {
  const ScratchFolder folder;
  const fs::path path = folder.write("rich.glb", rich_file().glb());
  auto known = stamped_digest_of(path, 1 << 30);
  ASSERT_TRUE(known.ok());
  EXPECT_EQ(known->digest, load(path).sources.at(0).digest);
  EXPECT_FALSE(known->holds(path))
      << "it has just been written: that could happen again within a tick of its clock";
  known->taken_ns += 4'000'000'000;
  EXPECT_FALSE(known->holds(path));
  known->taken_ns += 2'000'000'000;
  EXPECT_TRUE(known->holds(path));
  const Digest other = known->digest;
  known->digest[0] ^= 1;  // a changed digest reveals its use
  std::vector<SourceFile> sources;
  ASSERT_TRUE(load_gltf(path, {}, {}, &sources, &*known).ok());
  EXPECT_EQ(sources.at(0).digest, known->digest);
  fs::last_write_time(path, fs::last_write_time(path) + std::chrono::seconds(1));
  EXPECT_FALSE(known->holds(path));
  sources.clear();
  ASSERT_TRUE(load_gltf(path, {}, {}, &sources, &*known).ok());
  EXPECT_EQ(sources.at(0).digest, other);
  fs::remove(path);
  EXPECT_FALSE(known->holds(path));
}

TEST(SceneCache, ReadsReturnWhatWasStored) {
  const ScratchFolder folder;
  const fs::path asset = folder.write("rich.glb", rich_file().glb());
  const Loaded loaded = load(asset);
  const SceneCacheSettings settings = in_folder(folder.path() / "cache");
  EXPECT_FALSE(find(settings, asset));
  ASSERT_TRUE(SceneCache(settings).store(asset, loaded.scene, loaded.sources).ok());
  const auto cached = find(settings, asset);
  ASSERT_TRUE(cached);
  EXPECT_EQ(cached->scene.source, asset);
  EXPECT_EQ(cached->scene.nodes.size(), loaded.scene.scene.nodes.size());
  EXPECT_EQ(written(folder, *cached), written(folder, loaded.scene));
  EXPECT_EQ(files_in(settings.folder), 2u) << "the scene and its digest";
}

TEST(SceneCache, StoringSceneStoresItsDigest) {
  const ScratchFolder folder;
  const fs::path asset = folder.write("rich.glb", rich_file().glb());
  const Loaded loaded = load(asset);
  const SceneCacheSettings settings = in_folder(folder.path() / "cache");
  SceneCache cache(settings);
  EXPECT_FALSE(cache.find(asset, LoadLimits().max_file_bytes));
  ASSERT_TRUE(cache.store(asset, loaded.scene, loaded.sources).ok());
  EXPECT_EQ(files_in(settings.folder), 2u);
}

TEST(SceneCache, EqualBytesShareAnEntry) {
  const ScratchFolder folder;
  const fs::path asset = folder.write("rich.glb", rich_file().glb());
  const Loaded loaded = load(asset);
  const SceneCacheSettings settings = in_folder(folder.path() / "cache");
  ASSERT_TRUE(SceneCache(settings).store(asset, loaded.scene, loaded.sources).ok());
  fs::copy_file(asset, folder.path() / "other.glb");
  const auto cached = find(settings, folder.path() / "other.glb");
  ASSERT_TRUE(cached);
  EXPECT_EQ(cached->scene.source.filename(), "other.glb");
}

TEST(SceneCache, ChangedFileIsLoadedAgain) {
  const ScratchFolder folder;
  test::GltfBuilder b = rich_file();
  const std::vector<std::byte> image = test::png(4, 4, 0xff0000ff);
  folder.write("colour.png", image);
  b.root["images"][0] = {{"uri", "colour.png"}};
  const fs::path asset = folder.write("rich.gltf", b.gltf("rich.bin"));
  folder.write("rich.bin", b.bin);
  const SceneCacheSettings settings = in_folder(folder.path() / "cache");
  const auto store = [&] {
    const Loaded loaded = load(asset);
    EXPECT_EQ(loaded.sources.size(), 3u);
    ASSERT_TRUE(SceneCache(settings).store(asset, loaded.scene, loaded.sources).ok());
    ASSERT_TRUE(find(settings, asset));
  };
  store();

  folder.write("colour.png", test::png(4, 4, 0xff00ff00));
  EXPECT_FALSE(find(settings, asset)) << "a texture has changed";
  store();
  EXPECT_EQ(find(settings, asset)->scene.images[0].rgba8[0], 0x00);

  std::vector<std::byte> bin = b.bin;
  bin[0] ^= std::byte{1};
  folder.write("rich.bin", bin);
  EXPECT_FALSE(find(settings, asset)) << "a buffer has changed";
  store();
  fs::remove(folder.path() / "rich.bin");
  EXPECT_FALSE(find(settings, asset)) << "a buffer is gone";

  folder.write("rich.bin", bin);
  ASSERT_TRUE(find(settings, asset));
  b.root["nodes"][0]["name"] = "renamed";
  folder.write("rich.gltf", b.gltf("rich.bin"));
  EXPECT_FALSE(find(settings, asset)) << "the asset's own file has changed";
}

TEST(SceneCache, AppearingImageIsLoaded) {
  const ScratchFolder folder;
  test::GltfBuilder b = rich_file();
  b.root["images"][0] = {{"uri", "colour.png"}};
  const fs::path asset = folder.write("rich.glb", b.glb());
  const SceneCacheSettings settings = in_folder(folder.path() / "cache");
  const Loaded loaded = load(asset);
  ASSERT_EQ(loaded.sources.size(), 2u);
  EXPECT_EQ(loaded.sources[1].uri, "colour.png");
  EXPECT_EQ(loaded.sources[1].digest, Digest{});
  ASSERT_TRUE(SceneCache(settings).store(asset, loaded.scene, loaded.sources).ok());
  const auto cached = find(settings, asset);
  ASSERT_TRUE(cached) << "the image is still missing";
  EXPECT_EQ(cached->scene.images[0].width, 64u);
  ASSERT_FALSE(cached->scene.warnings.empty());
  EXPECT_NE(cached->scene.warnings[0].find("No such file"), std::string::npos);

  folder.write("colour.png", test::png(4, 4, 0xff00ff00));
  EXPECT_FALSE(find(settings, asset));
  const Loaded whole = load(asset);
  ASSERT_TRUE(SceneCache(settings).store(asset, whole.scene, whole.sources).ok());
  EXPECT_EQ(find(settings, asset)->scene.images[0].width, 4u);
  fs::remove(folder.path() / "colour.png");
  EXPECT_FALSE(find(settings, asset)) << "it is gone";
}

TEST(SceneCache, BesideAssetOnlyOnRequest) {
  const ScratchFolder folder;
  const fs::path asset = folder.write("rich.glb", rich_file().glb());
  const Loaded loaded = load(asset);
  SceneCacheSettings settings;
  ASSERT_TRUE(SceneCache(settings).store(asset, loaded.scene, loaded.sources).ok());
  EXPECT_EQ(files_in(folder.path()), 1u);
  settings.place = SceneCacheSettings::Place::beside_the_asset;
  settings.least_scene_bytes = 0;
  ASSERT_TRUE(SceneCache(settings).store(asset, loaded.scene, loaded.sources).ok());
  EXPECT_TRUE(fs::exists(folder.path() / "rich.glb.fire3dv-cache"));
  EXPECT_TRUE(find(settings, asset));
}

TEST(SceneCache, SmallScenesAreNotCached) {
  const ScratchFolder folder;
  const fs::path asset = folder.write("rich.glb", rich_file().glb());
  const Loaded loaded = load(asset);
  SceneCacheSettings settings = in_folder(folder.path() / "cache");
  settings.least_scene_bytes = SceneCacheSettings().least_scene_bytes;
  ASSERT_TRUE(SceneCache(settings).store(asset, loaded.scene, loaded.sources).ok());
  EXPECT_FALSE(fs::exists(settings.folder));
}

TEST(SceneCache, LeastRecentlyUsedGoFirst) {
  const ScratchFolder folder;
  const auto add = [&](const char* name, int hours_ago) {
    write(folder.path() / name, std::string(100, 'x'));
    fs::last_write_time(folder.path() / name,
                        fs::file_time_type::clock::now() - std::chrono::hours(hours_ago));
  };
  add("a.scene", 3);
  add("b.scene", 9);
  add("c.scene", 1);
  add("mine.txt", 99);
  add("d.scene.part-abcdef", 2);
  add("e.scene.part-abcdef", 0);
  touch(folder.path() / "b.scene");
  remove_oldest(folder.path(), ".scene", 250);
  EXPECT_FALSE(fs::exists(folder.path() / "a.scene"));
  EXPECT_TRUE(fs::exists(folder.path() / "b.scene"));
  EXPECT_TRUE(fs::exists(folder.path() / "c.scene"));
  EXPECT_TRUE(fs::exists(folder.path() / "mine.txt")) << "not ours";
  EXPECT_FALSE(fs::exists(folder.path() / "d.scene.part-abcdef")) << "its writer is long gone";
  EXPECT_TRUE(fs::exists(folder.path() / "e.scene.part-abcdef")) << "someone may be writing it";
}

TEST(SceneCache, UnwritableFolderIsNamed) {
  const ScratchFolder folder;
  const fs::path asset = folder.write("rich.glb", rich_file().glb());
  const Loaded loaded = load(asset);
  write(folder.path() / "taken", "a file");
  const auto cached =
      SceneCache(in_folder(folder.path() / "taken" / "cache")).store(asset, loaded.scene, loaded.sources);
  ASSERT_FALSE(cached.ok());
  EXPECT_NE(cached.error().message.find("taken"), std::string::npos);
  fs::create_directory(folder.path() / "nowhere.glb.fire3dv-cache");
  SceneCacheSettings beside = in_folder("");
  beside.place = SceneCacheSettings::Place::beside_the_asset;
  EXPECT_FALSE(SceneCache(beside).store(folder.path() / "nowhere.glb", loaded.scene, loaded.sources).ok());
  EXPECT_EQ(files_in(folder.path()), 2u) << "no temporary file is left";
}

TEST(SceneCache, ConcurrentAccessIsSafe) {
  const ScratchFolder folder;
  const fs::path asset = folder.write("rich.glb", rich_file().glb());
  const Loaded loaded = load(asset);
  const SceneCacheSettings settings = in_folder(folder.path() / "cache");
  ASSERT_TRUE(SceneCache(settings).store(asset, loaded.scene, loaded.sources).ok());
  std::atomic<int> found{0}, written_well{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 2; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 20; ++i)
          written_well += SceneCache(settings).store(asset, loaded.scene, loaded.sources).ok() ? 1 : 0;
      });
      threads.emplace_back([&] {
        for (int i = 0; i < 20; ++i) found += find(settings, asset) ? 1 : 0;
      });
    }
  }
  EXPECT_EQ(written_well, 40);
  EXPECT_EQ(found, 40);
  EXPECT_EQ(files_in(settings.folder), 2u) << "the scene and its digest";
}

class DamagedSceneFile : public testing::Test {
 protected:
  DamagedSceneFile() : asset_(folder_.write("rich.glb", rich_file().glb())), loaded_(load(asset_)) {
    EXPECT_TRUE(write_scene_file(path_, loaded_.scene, loaded_.sources).ok());
    good_ = bytes_of(path_);
  }

  // Changes one byte in place: writing the whole file takes longer than reading it.
  void put(size_t at, char byte) {
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(at)).put(byte);
  }

  ScratchFolder folder_;
  fs::path asset_, path_ = folder_.path() / "cached";
  Loaded loaded_;
  std::string good_;
};

// Only the padding between arrays has no checksum: damage there gives the same scene.
TEST_F(DamagedSceneFile, IsRefusedOutsideOfPadding) {
  ASSERT_TRUE(read_scene_file(path_).ok());
  constexpr size_t kHeadBytes = 104, kSectionSizesAt = 48;
  uint64_t sections[3];
  std::memcpy(sections, good_.data() + kSectionSizesAt, sizeof(sections));
  const uint64_t padding =
      good_.size() - kHeadBytes - sections[0] - sections[1] - sections[2] - array_bytes(loaded_.scene);
  const std::string same = written(folder_, loaded_.scene);
  uint64_t accepted = 0;
  for (size_t i = 0; i < good_.size(); ++i) {
    put(i, static_cast<char>(good_[i] ^ (1 << i % 8)));
    const auto read = read_scene_file(path_);
    put(i, good_[i]);
    if (!read) continue;
    ++accepted;
    EXPECT_EQ(good_[i], '\0') << "byte " << i;
    EXPECT_EQ(written(folder_, read->loaded), same) << "byte " << i;
  }
  EXPECT_EQ(accepted, padding);
}

// Entries with valid checksums, as an untrusted bundle could contain them.
TEST_F(DamagedSceneFile, InvalidNumbersAreRefused) {
  const float infinity = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  const std::pair<const char*, std::function<void(Scene&)>> faults[] = {
      {"light colour", [&](Scene& s) { s.lights[0].color.y = nan; }},
      {"light intensity", [&](Scene& s) { s.lights[0].intensity = infinity; }},
      {"negative intensity", [&](Scene& s) { s.lights[0].intensity = -1; }},
      {"light range", [&](Scene& s) { s.lights[0].range_m = nan; }},
      {"light radius", [&](Scene& s) { s.lights[0].radius_m = -1; }},
      {"light cone", [&](Scene& s) { s.lights[0].outer_cone_rad = nan; }},
      {"light angle", [&](Scene& s) { s.lights[0].angular_radius_rad = 7; }},
      {"camera angle", [&](Scene& s) { s.cameras[0].vertical_fov_rad = 4; }},
      {"camera near", [&](Scene& s) { s.cameras[0].near_m = nan; }},
      {"camera far", [&](Scene& s) { s.cameras[0].far_m = nan; }},
      {"camera exposure", [&](Scene& s) { s.cameras[0].exposure = infinity; }},
      {"camera lens",
       [&](Scene& s) {
         s.cameras[0].lens = {2, 0};
       }},
      {"camera focus",
       [&](Scene& s) {
         s.cameras[0].lens = {2, nan};
       }},
      {"camera extent", [&](Scene& s) { s.cameras[0].half_extent_m.x = nan; }},
      {"node transform", [&](Scene& s) { s.nodes[0].parent_from_node[3][0] = nan; }},
      {"material colour", [&](Scene& s) { s.materials[0].base_color.x = nan; }},
      {"material factor", [&](Scene& s) { s.materials[0].roughness = infinity; }},
      {"material emission", [&](Scene& s) { s.materials[0].emissive.z = nan; }},
      {"texture transform", [&](Scene& s) { s.materials[0].base_color_texture.uv_scale.x = nan; }},
      {"bounds", [&](Scene& s) { s.bounds_max.x = infinity; }}};
  for (const auto& [what, change] : faults) {
    LoadedScene changed = loaded_.scene;
    change(changed.scene);
    ASSERT_TRUE(write_scene_file(path_, changed, loaded_.sources).ok());
    EXPECT_FALSE(read_scene_file(path_).ok()) << what;
  }
}

TEST_F(DamagedSceneFile, WrongLengthIsRefused) {
  for (size_t size = 0; size < good_.size(); size += 1 + good_.size() / 97) {
    write(path_, good_.substr(0, size));
    EXPECT_FALSE(read_scene_file(path_).ok()) << size;
    EXPECT_FALSE(read_scene_sources(path_).ok() && size < 104) << size;
  }
  write(path_, good_ + "x");
  EXPECT_FALSE(read_scene_file(path_).ok());
  fs::remove(path_);
  EXPECT_FALSE(read_scene_file(path_).ok());
  fs::create_directory(path_);
  EXPECT_FALSE(read_scene_file(path_).ok());
}

TEST_F(DamagedSceneFile, RubbishIsRefused) {
  for (const std::string& rubbish :
       {std::string("not a scene"), std::string(4096, '\0'), std::string(4096, '\xff')}) {
    write(path_, rubbish);
    EXPECT_FALSE(read_scene_file(path_).ok());
    EXPECT_FALSE(read_scene_sources(path_).ok());
  }
}

// Entries with valid checksums and inconsistent contents, made on purpose.
TEST_F(DamagedSceneFile, HeadersMatchContents) {
  using Change = std::function<void(LoadedScene&)>;
  const std::vector<std::pair<const char*, Change>> changes = {
      {"index of a vertex", [](LoadedScene& l) { l.scene.indices[0] = 1000; }},
      {"position", [](LoadedScene& l) { l.scene.positions[0].x = NAN; }},
      {"tangent frames", [](LoadedScene& l) { l.scene.frames.pop_back(); }},
      {"tangents of some vertices", [](LoadedScene& l) { l.scene.tangents.resize(1); }},
      {"texture coordinates", [](LoadedScene& l) { l.scene.uvs.pop_back(); }},
      {"one texture coordinate", [](LoadedScene& l) { l.scene.uvs[0].y = INFINITY; }},
      {"extras of some vertices", [](LoadedScene& l) { l.scene.extras.resize(1); }},
      {"coordinate of the second set",
       [](LoadedScene& l) {
         l.scene.extras.resize(l.scene.positions.size());
         l.scene.extras[0].uv1.x = NAN;
       }},
      {"first index", [](LoadedScene& l) { l.scene.primitives[0].first_index = UINT32_MAX; }},
      {"index count", [](LoadedScene& l) { l.scene.primitives[0].index_count = 2; }},
      {"vertex count", [](LoadedScene& l) { l.scene.primitives[0].vertex_count = UINT32_MAX; }},
      {"topology", [](LoadedScene& l) { l.scene.primitives[0].topology = static_cast<Topology>(9); }},
      {"material", [](LoadedScene& l) { l.scene.primitives[0].material = 99; }},
      {"no material", [](LoadedScene& l) { l.scene.materials.clear(); }},
      {"bounds", [](LoadedScene& l) { l.scene.primitives[0].bounds_min.y = NAN; }},
      {"morph deltas", [](LoadedScene& l) { l.scene.morph_deltas.pop_back(); }},
      {"influences", [](LoadedScene& l) { l.scene.influences.pop_back(); }},
      {"joint of a vertex", [](LoadedScene& l) { l.scene.influences[0].joints[2] = 9; }},
      {"weight of a joint", [](LoadedScene& l) { l.scene.influences[0].weights[2] = NAN; }},
      {"joint bounds", [](LoadedScene& l) { l.scene.joint_bounds[0].joint = 9; }},
      {"primitives of a mesh", [](LoadedScene& l) { l.scene.meshes[0].primitive_count = UINT32_MAX; }},
      {"morph targets of a mesh", [](LoadedScene& l) { l.scene.meshes[0].morph_target_count = 7; }},
      {"mesh", [](LoadedScene& l) { l.scene.nodes[0].mesh = 99; }},
      {"parent", [](LoadedScene& l) { l.scene.nodes[0].parent = 0; }},
      {"camera", [](LoadedScene& l) { l.scene.nodes[0].camera = 99; }},
      {"light", [](LoadedScene& l) { l.scene.nodes[0].light = 99; }},
      {"skin", [](LoadedScene& l) { l.scene.nodes[0].skin = 99; }},
      {"transform", [](LoadedScene& l) { l.scene.nodes[0].world_from_node[3].x = INFINITY; }},
      {"morph weights", [](LoadedScene& l) { l.scene.morph_weights.clear(); }},
      {"joints of a skin", [](LoadedScene& l) { l.scene.skins[0].joint_count = 99; }},
      {"fewer joints than are used", [](LoadedScene& l) { l.scene.skins[0].joint_count = 1; }},
      {"node of a joint", [](LoadedScene& l) { l.scene.joints[0].node = 99; }},
      {"channels", [](LoadedScene& l) { l.scene.animations[0].channel_count = 99; }},
      {"node of a channel", [](LoadedScene& l) { l.scene.channels[0].node = 99; }},
      {"path of a channel", [](LoadedScene& l) { l.scene.channels[0].path = static_cast<AnimationPath>(9); }},
      {"keys", [](LoadedScene& l) { l.scene.channels[0].key_count = 0; }},
      {"values of keys", [](LoadedScene& l) { l.scene.channels[0].first_value = UINT32_MAX; }},
      {"width of values", [](LoadedScene& l) { l.scene.channels[0].width = 1; }},
      {"order of keys", [](LoadedScene& l) { l.scene.key_times_s[1] = -1; }},
      {"image of a texture", [](LoadedScene& l) { l.scene.textures[0].image = 99; }},
      {"wrapping", [](LoadedScene& l) { l.scene.textures[0].sampler.wrap_u = static_cast<Wrap>(9); }},
      {"pixels", [](LoadedScene& l) { l.scene.images[0].rgba8.edit().pop_back(); }},
      {"size of an image", [](LoadedScene& l) { l.scene.images[0].height = 0x40000000; }},
      {"texture of a material",
       [](LoadedScene& l) { l.scene.materials[1].sheen_color_texture.texture = 99; }},
      {"coordinates of a texture",
       [](LoadedScene& l) { l.scene.materials[1].base_color_texture.uv_set = 2; }},
      {"alpha mode", [](LoadedScene& l) { l.scene.materials[1].alpha_mode = static_cast<AlphaMode>(9); }},
      {"type of a light", [](LoadedScene& l) { l.scene.lights[0].type = static_cast<LightType>(9); }},
      {"source vertex", [](LoadedScene& l) { l.derived.clusters.source_vertices[0] = 1000; }},
      {"vertex of another primitive", [](LoadedScene& l) { l.derived.clusters.source_vertices[0] = 5; }},
      {"first vertex of a cluster", [](LoadedScene& l) { l.derived.clusters.clusters[1].first_vertex = 0; }},
      {"triangles of a cluster", [](LoadedScene& l) { l.derived.clusters.clusters[0].triangle_count = 100; }},
      {"vertices of a cluster", [](LoadedScene& l) { l.derived.clusters.clusters[0].vertex_count = 1000; }},
      {"corner of a triangle", [](LoadedScene& l) { l.derived.clusters.triangles[0] = 0x00ff00; }},
      {"sphere", [](LoadedScene& l) { l.derived.clusters.clusters[0].radius = NAN; }},
      {"first index", [](LoadedScene& l) { l.derived.clusters.primitives[1].first_index += 3; }},
      {"number of indices", [](LoadedScene& l) { l.derived.clusters.primitives[0].index_count -= 3; }},
      {"missing triangle", [](LoadedScene& l) { --l.derived.clusters.clusters[0].triangle_count; }},
      {"ray boxes", [](LoadedScene& l) { l.derived.clusters.primitives[0].ray_box_count = 1000; }},
      {"corner of a ray box", [](LoadedScene& l) { l.derived.clusters.ray_boxes[0].high.y = NAN; }},
      {"first vertex of a ray box",
       [](LoadedScene& l) { l.derived.clusters.ray_boxes[0].first_vertex = 1000; }},
      {"triangles of a ray box",
       [](LoadedScene& l) { l.derived.clusters.ray_boxes[0].triangles = 0xf0000000u; }},
      {"clusters", [](LoadedScene& l) { l.derived.clusters.primitives[0].cluster_count = 99; }},
      {"primitives", [](LoadedScene& l) { l.derived.clusters.primitives.pop_back(); }},
      {"casters", [](LoadedScene& l) { l.derived.casters.pop_back(); }},
      {"shape of a caster", [](LoadedScene& l) { l.derived.casters[0].shape = static_cast<CasterShape>(9); }},
  };
  EXPECT_TRUE(check_scene(loaded_.scene.scene).ok());
  EXPECT_TRUE(check_derived(loaded_.scene.scene, loaded_.scene.derived).ok());
  for (const auto& [what, change] : changes) {
    LoadedScene bad = loaded_.scene;
    change(bad);
    ASSERT_TRUE(write_scene_file(path_, bad, loaded_.sources).ok());
    EXPECT_FALSE(read_scene_file(path_).ok()) << what;
  }
}

TEST_F(DamagedSceneFile, SourcesStayInAssetFolder) {
  const ScratchFolder elsewhere;
  const fs::path secret = elsewhere.write("secret", std::string_view("key"));
  const SceneCacheSettings settings = in_folder(folder_.path() / "cache");
  std::vector<SourceFile> sources = loaded_.sources;
  sources.push_back({secret.string(), *digest_of_file(secret, 100)});
  ASSERT_TRUE(SceneCache(settings).store(asset_, loaded_.scene, sources).ok());
  EXPECT_FALSE(find(settings, asset_)) << "a path out of the folder was read";
}

}  // namespace
}  // namespace fire3dv::scene
