// Render tests of energy conservation at oblique and grazing views: white surfaces in a white furnace, by
// paths and by the raster. Lamps: white_furnace_test.cpp. Bounds: docs/design/materials.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "tests/render/support/material_tiles.h"
#include "tests/render/support/render_bench.h"

namespace fire3dv::test {
namespace {

class MaterialEnergy : public ValidationIsSilent {};

Tile white_tile(const std::string& name, float metallic, float roughness,
                const std::function<void(scene::Material&)>& change) {
  Tile tile{name + ", roughness " + std::to_string(roughness), matte(glm::vec3(1))};
  tile.material.metallic = metallic;
  tile.material.roughness = roughness;
  change(tile.material);
  return tile;
}

std::vector<Tile> white_tiles() {
  const auto sheen = [](float roughness) {
    return [roughness](scene::Material& material) {
      material.sheen_color = glm::vec3(1);
      material.sheen_roughness = roughness;
    };
  };
  const auto brushed = [](float strength, float rotation_rad, float coat) {
    return [=](scene::Material& material) {
      material.anisotropy = strength;
      material.anisotropy_rotation_rad = rotation_rad;
      material.clearcoat = coat;
    };
  };
  const auto film = [](scene::Material& material) {
    material.iridescence = 1;
    material.iridescence_ior = 1.3f;
    material.iridescence_thickness_max_nm = 400;
  };
  const float quarter = 1.5708f;
  return {white_tile("metal", 1, 0.1f, [](scene::Material&) {}),
          white_tile("sheen 0.1", 0, 0.25f, sheen(0.1f)),
          white_tile("sheen 0.1 on metal", 1, 0.1f, sheen(0.1f)),
          white_tile("sheen 0.3 on metal", 1, 0.3f, sheen(0.3f)),
          white_tile("sheen 1 on metal", 1, 0.6f, sheen(1)),
          white_tile("clearcoat on metal", 1, 0.3f, [](scene::Material& m) { m.clearcoat = 1; }),
          white_tile("brushed along", 1, 0.25f, brushed(1, quarter, 0)),
          white_tile("brushed across", 1, 0.02f, brushed(1, 0, 0)),
          white_tile("brushed plastic", 0, 0.25f, brushed(1, 0, 0)),
          white_tile("brushed, coated", 1, 0.25f, brushed(0.8f, 0, 1)),
          white_tile("film on plastic", 0, 0.02f, film),
          white_tile("film on plastic", 0, 0.25f, film)};
}

TEST_F(MaterialEnergy, WhiteSurfacesShowFurnaceAtGrazingViews) {
  const std::vector<Tile> tiles = white_tiles();
  settings::DrawSettings raster = furnace_settings(1);
  raster.path.reset();
  for (const double degrees : {0.0, 45.0, 70.0, 85.0, 89.0}) {
    const glm::dvec3 to_eye = towards(degrees, 90);
    const auto traced = tile_pixels({}, tiles, to_eye, furnace_settings(64));
    const auto drawn = tile_pixels({}, tiles, to_eye, raster);
    const double least = degrees < 86 ? 0.98 : 0.95;
    for (size_t i = 0; i < tiles.size(); ++i) {
      const std::string what = tiles[i].name + ", " + std::to_string(degrees) + " degrees";
      const MeanRadiance seen = mean_radiance(traced[i]);
      const glm::dvec3 looked_up = mean_radiance(drawn[i]).mean;
      RecordProperty(what, std::to_string(seen.mean.r) + " " + std::to_string(seen.mean.g) + " " +
                               std::to_string(seen.mean.b) + " +- " + std::to_string(seen.error.g));
      for (int c = 0; c < 3; ++c) {
        EXPECT_LE(seen.mean[c], 1.02 + 3 * seen.error[c]) << what << ", channel " << c;
        EXPECT_GE(seen.mean[c], least - 3 * seen.error[c]) << what << ", channel " << c;
        EXPECT_LT(seen.error[c], 0.05) << what;
        EXPECT_NEAR(looked_up[c], 1, 0.005) << what << ", raster, channel " << c;
      }
    }
  }
}

}  // namespace
}  // namespace fire3dv::test
