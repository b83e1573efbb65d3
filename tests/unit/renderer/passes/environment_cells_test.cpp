// Test of the environment's alias table: the densities are those of the image, and the table draws cells by
// them.
#include "renderer/passes/path/environment_cells.h"

#include <gtest/gtest.h>

#include <cmath>

namespace fire3dv::passes {
namespace {

// Probability of each cell when the table is drawn from.
std::vector<double> probabilities(const EnvironmentCells& table) {
  std::vector<double> result(table.cells.size(), 0);
  const double each = 1.0 / static_cast<double>(table.cells.size());
  for (size_t i = 0; i < table.cells.size(); ++i) {
    result[i] += each * table.cells[i].threshold;
    result[table.cells[i].alias] += each * (1 - table.cells[i].threshold);
  }
  return result;
}

scene::EnvironmentImage sky_with_sun(uint32_t width, uint32_t height) {
  return scene::make_environment(width, height, [](const glm::vec3& direction) {
    return direction.y < 0       ? glm::vec3(0)
           : direction.x > 0.98f ? glm::vec3(5000)
                                 : glm::vec3(0.2f, 0.3f, 0.5f);
  });
}

TEST(EnvironmentCells, TableMatchesDensity) {
  for (const uint32_t width : {64u, 2048u}) {
    const EnvironmentCells table = make_environment_cells(sky_with_sun(width, width / 2));
    EXPECT_EQ(table.size, glm::uvec2(std::min(width, 1024u), std::min(width, 1024u) / 2));
    ASSERT_EQ(table.cells.size(), size_t{table.size.x} * table.size.y);
    const std::vector<double> drawn = probabilities(table);
    double sum = 0;
    for (size_t i = 0; i < drawn.size(); ++i) {
      const double wanted = table.cells[i].density / static_cast<double>(drawn.size());
      ASSERT_NEAR(drawn[i], wanted, 1e-6 * wanted + 1e-12) << i;
      ASSERT_GE(table.cells[i].threshold, 0);
      ASSERT_LE(table.cells[i].threshold, 1);
      ASSERT_LT(table.cells[i].alias, drawn.size());
      sum += drawn[i];
    }
    EXPECT_NEAR(sum, 1, 1e-6);
  }
}

// Bilinear filtering carries a texel's light half a texel beyond its border: those cells are drawn, too.
TEST(EnvironmentCells, BrightNeighboursAreDrawn) {
  const uint32_t width = 16, height = 8;
  scene::EnvironmentImage image;
  image.width = width;
  image.height = height;
  image.rgb9e5.assign(size_t{width} * height, 0);
  image.rgb9e5[size_t{3} * width] = scene::pack_rgb9e5(glm::vec3(1));  // at the seam
  const EnvironmentCells table = make_environment_cells(image);
  ASSERT_FALSE(table.cells.empty());
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const bool near = y >= 2 && y <= 4 && (x <= 1 || x == width - 1);
      EXPECT_EQ(table.cells[size_t{y} * width + x].density > 0, near) << x << ", " << y;
    }
  }
}

TEST(EnvironmentCells, ABlackImageHasNone) {
  EXPECT_TRUE(make_environment_cells(scene::make_environment(8, 4, [](const glm::vec3&) {
                return glm::vec3(0);
              })).cells.empty());
}

// Sizes that no block of texels divides are drawn evenly rather than wrongly.
TEST(EnvironmentCells, OddSizesAreDrawnEvenly) {
  const EnvironmentCells table = make_environment_cells(
      scene::make_environment(1537, 700, [](const glm::vec3&) { return glm::vec3(1); }));
  ASSERT_EQ(table.cells.size(), 1u);
  EXPECT_EQ(table.cells[0].density, 1);
}

}  // namespace
}  // namespace fire3dv::passes
