// Robustness test of faulty assets: each file is refused with a reason or drawn without validation messages.
// Sanitizer builds run it, too.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/render/assets/asset_collection.h"
#include "tests/render/support/render_bench.h"
#include "tests/support/asset_collection_folder.h"
#include "tests/unit/renderer/scene/gltf/motion_file.h"
#include "tools/lab/contact_sheet/asset_drawer.h"

namespace fire3dv::test {
namespace {

class BrokenAssets : public ValidationIsSilent {
 protected:
  static settings::DrawSettings settings_of(settings::RasterPath raster) {
    settings::DrawSettings settings;
    settings.raster = raster;
    settings.samples = 1;
    return settings;
  }

  // Draws with both raster paths and with shadows, to exercise all code for the scene.
  void expect_refused_or_drawn(const std::filesystem::path& file) {
    SCOPED_TRACE(file);
    const Result<scene::Scene> scene = scene::load_gltf(file);
    if (!scene) {
      ++refused_;
      EXPECT_NE(scene.error().message.find(file.filename().string()), std::string::npos)
          << scene.error().message;
      return;
    }
    ++drawn_;
    for (contact_sheet::AssetDrawer* drawer : {&visibility_, &forward_})
      EXPECT_EQ(drawer->draw_framed(*scene).rgba8.size(), size_t{4} * 48 * 48);
    EXPECT_EQ(instance().validation_messages(), 0u);
  }

  contact_sheet::AssetDrawer visibility_{device(), {48, 48}, settings_of(settings::RasterPath::visibility)};
  contact_sheet::AssetDrawer forward_{device(), {48, 48}, settings_of(settings::RasterPath::forward)};
  uint32_t drawn_ = 0, refused_ = 0;
};

TEST_F(BrokenAssets, CollectionIsRefusedOrDrawnSafely) {
  FIRE3DV_NEEDS_ASSETS();
  for (const CollectedAsset& asset : collected_assets()) {
    if (asset.faulty) expect_refused_or_drawn(asset.path);
  }
  std::cout << "faulty public assets: " << drawn_ << " drawn, " << refused_ << " refused\n";
  EXPECT_GT(refused_, 0u);
}

// Damages the bytes of vertices, joints, weights and keys: the glTF stays valid with arbitrary values.
TEST_F(BrokenAssets, DamagedFilesAreRefusedOrDrawn) {
  const ScratchFolder folder;
  const GltfBuilder good = motion_file();
  for (size_t i = 0; i < good.bin.size(); i += 5) {
    GltfBuilder damaged = good;
    for (size_t b = i; b < std::min(i + 2, damaged.bin.size()); ++b) damaged.bin[b] ^= std::byte{0xff};
    expect_refused_or_drawn(folder.write("damaged.glb", damaged.glb()));
  }
  std::cout << "damaged files: " << drawn_ << " drawn, " << refused_ << " refused\n";
  EXPECT_GT(drawn_, 0u);
  EXPECT_GT(refused_, 0u);
}

}  // namespace
}  // namespace fire3dv::test
