#include "renderer/passes/path/environment_cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace fire3dv::passes {
namespace {

constexpr uint32_t kMaxCellsX = 1024;
constexpr double kPi = 3.14159265358979;

// Mean luminance of each cell.
std::vector<double> cell_luminances(const scene::EnvironmentImage& image, glm::uvec2 size, uint32_t step) {
  std::vector<double> luminances(size_t{size.x} * size.y, 0);
  std::vector<uint32_t> counts(luminances.size(), 0);
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      const glm::dvec3 color(scene::unpack_rgb9e5(image.rgb9e5[size_t{y} * image.width + x]));
      const size_t cell = size_t{y / step} * size.x + x / step;
      luminances[cell] += glm::dot(color, glm::dvec3(0.2126, 0.7152, 0.0722));
      ++counts[cell];
    }
  }
  for (size_t i = 0; i < luminances.size(); ++i) luminances[i] /= std::max(counts[i], 1u);
  return luminances;
}

double mean_around(const std::vector<double>& values, glm::uvec2 size, uint32_t x, uint32_t y) {
  double sum = 0;
  for (uint32_t dy = 0; dy < 3; ++dy) {
    const uint32_t row = std::clamp(y + dy, 1u, size.y) - 1;
    for (uint32_t dx = 0; dx < 3; ++dx) sum += values[size_t{row} * size.x + (x + dx + size.x - 1) % size.x];
  }
  return sum / 9;
}

}  // namespace

EnvironmentCells make_environment_cells(const scene::EnvironmentImage& image) {
  EnvironmentCells result;
  const uint32_t step = (image.width + kMaxCellsX - 1) / kMaxCellsX;
  if (step == 0 || image.height == 0) return result;
  const glm::uvec2 size((image.width + step - 1) / step, (image.height + step - 1) / step);
  // Only whole blocks of texels keep the mapping from texels to cells.
  if (image.width % step != 0 || image.height % step != 0) {
    result.size = {1, 1};
    result.cells = {{1, 0, 1}};
    return result;
  }
  const std::vector<double> luminances = cell_luminances(image, size, step);
  std::vector<double> weights(luminances.size());
  double sum = 0;
  for (uint32_t y = 0; y < size.y; ++y) {
    const double sine = std::sin(kPi * (y + 0.5) / size.y);
    for (uint32_t x = 0; x < size.x; ++x)
      sum += weights[size_t{y} * size.x + x] = mean_around(luminances, size, x, y) * sine;
  }
  if (!(sum > 0)) return result;
  result.size = size;
  result.cells.resize(weights.size());
  // Vose's construction: each cell below the mean is filled up by one above it.
  std::vector<uint32_t> below, above;
  const auto count = static_cast<double>(weights.size());
  for (uint32_t i = 0; i < weights.size(); ++i) {
    weights[i] *= count / sum;
    result.cells[i] = {1, i, static_cast<float>(weights[i])};
    (weights[i] < 1 ? below : above).push_back(i);
  }
  while (!below.empty() && !above.empty()) {
    const uint32_t low = below.back(), high = above.back();
    below.pop_back();
    result.cells[low].threshold = static_cast<float>(weights[low]);
    result.cells[low].alias = high;
    weights[high] -= 1 - weights[low];
    if (weights[high] >= 1) continue;
    above.pop_back();
    below.push_back(high);
  }
  return result;
}

}  // namespace fire3dv::passes
