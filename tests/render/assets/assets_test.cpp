// Render test of valid assets against the oracle table, on both raster paths. The test also proves that a
// blank image, and one with default materials, fails each row.
#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/render/assets/asset_collection.h"
#include "tests/render/assets/asset_oracles.h"
#include "tests/render/proofs/computed_coverage.h"
#include "tests/render/support/render_bench.h"
#include "tests/support/asset_collection_folder.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

namespace fs = std::filesystem;
using contact_sheet::AssetDrawer;

constexpr VkExtent2D kExtent{kAssetSide, kAssetSide};
constexpr uint32_t kEdgePixels = 24;      // edge pixels that may differ between computed and drawn triangles
constexpr double kFarthestSample = 0.16;  // another renderer with other lights

const fs::path kTable = fs::path(FIRE3DV_SOURCE_DIR) / "tests" / "render" / "asset_oracles.txt";

settings::DrawSettings settings_of(settings::RasterPath raster) {
  settings::DrawSettings settings;
  settings.raster = raster;
  settings.samples = 1;
  settings.shadows.method = settings::ShadowMethod::off;
  settings.background.color = {0.06f, 0.0f, 0.12f};  // no asset has this colour
  settings.post.fxaa = false;
  return settings;
}

passes::View view_of(const scene::Scene& scene, const AssetOracle& oracle) {
  if (oracle.own_camera) return first_camera_view(scene, state::PoseState(scene), kExtent);
  if (!oracle.eye) return contact_sheet::framed_view(scene, 1);
  return passes::make_view(scene::Camera{}, passes::look_at_pose(*oracle.eye, glm::vec3(0)), 1);
}

scene::Scene with_default_materials(scene::Scene scene) {
  for (scene::Material& material : scene.materials) material = {};
  for (scene::VertexExtras& extras : scene.extras) extras.color = scene::VertexExtras().color;
  return scene;
}

uint64_t triangles_in_meshes(const scene::Scene& scene) {
  uint64_t count = 0;
  for (const scene::Primitive& primitive : scene.primitives) {
    if (primitive.topology == scene::Topology::triangles) count += primitive.index_count / 3;
  }
  return count;
}

std::string plain_name(const std::string& asset) {
  std::string name = "asset_" + asset;
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-') c = '_';
  }
  return name;
}

class Assets : public ValidationIsSilent {
 protected:
  void check(const CollectedAsset& asset) {
    SCOPED_TRACE(asset.name);
    const auto row = table_.find(asset.name);
    const AssetOracle known = row == table_.end() ? AssetOracle{} : row->second;
    EXPECT_TRUE(table_.contains(asset.name))
        << "no row in " << kTable << "; look at " << asset.path << " and add it";
    const Result<scene::Scene> scene = scene::load_gltf(asset.path);
    if (!scene) {
      AssetOracle refused = known;
      refused.look = Look::refused;
      measured_[asset.name] = refused;
      EXPECT_EQ(known.look, Look::refused) << scene.error().message;
      EXPECT_NE(scene.error().message.find(known.note), std::string::npos) << scene.error().message;
      return;
    }
    if (asset.triangles && known.look != Look::nothing) {
      EXPECT_EQ(triangles_in_meshes(*scene), *asset.triangles) << "as the validator counts";
    }
    const passes::View view = view_of(*scene, known);
    sinks::FrameImage image = drawer_.draw(*scene, view, passes::Pick{kAssetSide / 2, kAssetSide / 2, 1});
    expect_valid_pick(*scene);
    const MeasuredImage picture = describe_picture(std::move(image), blank_, drawer_.counts());
    EXPECT_EQ(disagreement(known, picture), "");
    EXPECT_TRUE(matches_image(forward_.draw(*scene, view), picture.image, plain_name(asset.name),
                              Tolerance::colour()));
    expect_computed_coverage(*scene, view, picture);
    if (known.sample) {
      EXPECT_LE(distance_to_sample(*known.sample, picture), kFarthestSample)
          << "from the collection's own picture";
    }
    const MeasuredImage default_picture = expect_oracle_rejects_defaults(*scene, view, known);
    note_measured(asset.name, known, picture, default_picture);
  }

  void TearDown() override {
    if (HasFailure()) write_measured();
    ValidationIsSilent::TearDown();
  }

 private:
  // A click on the middle of the image, by the path of the window: the node has a surface.
  void expect_valid_pick(const scene::Scene& scene) {
    const std::vector<passes::Picked> picked = drawer_.take_picked();
    ASSERT_EQ(picked.size(), 1u);
    const uint32_t node = picked[0].node;
    if (node == scene::kNone) return;  // the background
    ++picked_;
    ASSERT_LT(node, scene.nodes.size());
    EXPECT_NE(scene.nodes[node].mesh, scene::kNone) << scene.nodes[node].name;
    const glm::vec3 at = picked[0].position_world;
    const glm::vec3 margin(1e-3f * (1 + glm::length(scene.bounds_max - scene.bounds_min)));
    EXPECT_TRUE(glm::all(glm::greaterThan(at, scene.bounds_min - margin)) &&
                glm::all(glm::lessThan(at, scene.bounds_max + margin)))
        << at.x << " " << at.y << " " << at.z;
  }

  void expect_computed_coverage(const scene::Scene& scene, const passes::View& view,
                                const MeasuredImage& picture) {
    const std::optional<uint32_t> computed = computed_coverage(scene, view, kAssetSide);
    if (!computed) return;
    ++coverages_computed_;
    EXPECT_NEAR(picture.covered, *computed, kEdgePixels) << "pixels covered, drawn and computed";
  }

  // Expects that blank and default images disagree with the oracle. Returns the second one.
  MeasuredImage expect_oracle_rejects_defaults(const scene::Scene& scene, const passes::View& view,
                                               const AssetOracle& known) {
    const MeasuredImage blank = describe_picture(blank_, blank_, known.counts);
    EXPECT_EQ(disagreement(known, blank).empty(), known.look == Look::nothing) << "a blank image";
    const scene::Scene plain = with_default_materials(scene);
    MeasuredImage default_picture = describe_picture(drawer_.draw(plain, view), blank_, known.counts);
    EXPECT_EQ(disagreement(known, default_picture).empty(), known.look != Look::own)
        << "an image with default materials";
    return default_picture;
  }

  void note_measured(const std::string& name, const AssetOracle& known, const MeasuredImage& picture,
                     MeasuredImage default_picture) {
    AssetOracle oracle = known;
    oracle.counts = default_picture.counts = picture.counts;
    oracle.covered = picture.covered;
    oracle.grid = picture.grid;
    oracle.look = Look::own;
    if (disagreement(oracle, default_picture).empty()) oracle.look = Look::plain;
    if (picture.covered == 0) oracle.look = Look::nothing;
    measured_[name] = oracle;
  }

  // Writes the measured table, for review and update.
  void write_measured() const {
    const char* given = std::getenv("FIRE3DV_TEST_IMAGE_DIR");
    const fs::path folder = given && *given ? given : FIRE3DV_IMAGE_DIR;
    std::error_code ignored;
    fs::create_directories(folder, ignored);
    const fs::path file = folder / "asset_oracles.new.txt";
    std::ofstream out(file);
    AssetTable rest = measured_;
    std::ifstream lines(kTable);
    for (std::string line; std::getline(lines, line);) {
      const auto row = rest.find(line.substr(0, line.find(" | ")));
      out << (row == rest.end() ? line : table_row(row->first, row->second)) << '\n';
      if (row != rest.end()) rest.erase(row);
    }
    for (const auto& [name, oracle] : rest) out << table_row(name, oracle) << '\n';
    std::cout << "the table as measured now: " << file << '\n';
  }

 protected:
  AssetDrawer drawer_{device(), kExtent, settings_of(settings::RasterPath::visibility)};
  AssetDrawer forward_{device(), kExtent, settings_of(settings::RasterPath::forward)};
  const sinks::FrameImage blank_ = drawer_.draw_nothing();
  const AssetTable table_ = read_asset_table(kTable);
  static inline AssetTable measured_;  // of all tests in this run
  uint32_t coverages_computed_ = 0, picked_ = 0;
};

TEST_F(Assets, MadeHereLookAsTableSays) {
  const MadeAssets made;
  for (const CollectedAsset& asset : made.assets()) check(asset);
  EXPECT_GT(coverages_computed_, 0u);
}

TEST_F(Assets, CollectionLooksAsTheTableSays) {
  FIRE3DV_NEEDS_ASSETS();
  uint32_t valid = 0;
  for (const CollectedAsset& asset : collected_assets()) {
    if (asset.faulty) continue;
    ++valid;
    check(asset);
  }
  std::cout << valid << " valid public assets, " << coverages_computed_ << " with computed coverage\n";
  EXPECT_GT(valid, 0u);
  EXPECT_GT(coverages_computed_, 0u);
  EXPECT_GT(picked_, valid / 2) << "of the clicks on the middle hit a surface";
}

// The same model in several formats: <model>/glTF, <model>/glTF-Binary, <model>/glTF-Embedded.
TEST_F(Assets, CollectionLooksSameInEachPacking) {
  FIRE3DV_NEEDS_ASSETS();
  std::map<std::string, std::pair<std::string, sinks::FrameImage>> first_of_model;
  uint32_t compared = 0;
  for (const CollectedAsset& asset : collected_assets()) {
    const std::string packing = asset.path.parent_path().filename().string();
    if (!packing.starts_with("glTF")) continue;
    const Result<scene::Scene> scene = scene::load_gltf(asset.path);
    if (!scene) continue;  // the table decides about refusals
    sinks::FrameImage image = drawer_.draw_framed(*scene);
    const std::string model = asset.path.parent_path().parent_path().string();
    const auto [first, is_first] = first_of_model.try_emplace(model, asset.name, image);
    if (is_first) continue;
    ++compared;
    EXPECT_TRUE(matches_image(image, first->second.second, plain_name(asset.name), Tolerance::exact()))
        << asset.name << " and " << first->second.first;
  }
  std::cout << compared << " files hold a model that another file has held\n";
  EXPECT_GT(compared, 0u);
}

}  // namespace
}  // namespace fire3dv::test
