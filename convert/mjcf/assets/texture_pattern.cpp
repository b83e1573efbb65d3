#include "convert/mjcf/assets/texture_pattern.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "convert/model.h"

namespace fire3dv::convert {
namespace {

using Pixel = std::array<uint8_t, 3>;

Pixel pixel_of(const glm::dvec3& color) {
  const glm::dvec3 scaled = 255.0 * glm::clamp(color, 0.0, 1.0);
  return {static_cast<uint8_t>(scaled.r), static_cast<uint8_t>(scaled.g), static_cast<uint8_t>(scaled.b)};
}

// Blend of two colours by a sigmoid of a value from -1 to 1.
glm::dvec3 blend(const glm::dvec3& above, const glm::dvec3& below, double value) {
  const double weight = 0.5 * (1 + value / std::sqrt(1 + value * value) * std::numbers::sqrt2);
  return glm::mix(below, above, std::clamp(weight, 0.0, 1.0));
}

}  // namespace

namespace {

using Draw = std::function<Pixel(uint32_t row, uint32_t column)>;

// face: what a pixel shows below the marks; null: black.
std::vector<uint8_t> draw(const TexturePattern& pattern, const Draw& face) {
  const uint32_t width = pattern.width, height = pattern.height;
  std::vector<uint8_t> rgb(size_t{3} * width * height);
  const auto set = [&](uint32_t row, uint32_t column, const Pixel& pixel) {
    std::copy(pixel.begin(), pixel.end(), rgb.begin() + 3 * (static_cast<ptrdiff_t>(row) * width + column));
  };
  for (uint32_t row = 0; face && row < height; ++row)
    for (uint32_t column = 0; column < width; ++column) set(row, column, face(row, column));
  const Pixel mark = pixel_of(pattern.mark_color);
  if (pattern.mark == "edge" || pattern.mark == "cross") {
    const bool is_edge = pattern.mark == "edge";
    for (uint32_t row = 0; row < height; ++row) {
      set(row, is_edge ? 0 : width / 2, mark);
      if (is_edge) set(row, width - 1, mark);
    }
    for (uint32_t column = 0; column < width; ++column) {
      set(is_edge ? 0 : height / 2, column, mark);
      if (is_edge) set(height - 1, column, mark);
    }
  } else if (pattern.mark == "random") {
    std::mt19937_64 generator(42);  // NOLINT: the same dots in each conversion
    std::uniform_real_distribution<double> share(0, 1);
    for (uint32_t row = 0; row < height; ++row)
      for (uint32_t column = 0; column < width; ++column)
        if (share(generator) < pattern.random) set(row, column, mark);
  }
  return rgb;
}

Draw checker(const TexturePattern& pattern) {
  return [&pattern](uint32_t row, uint32_t column) {
    const bool is_first = (row < pattern.height / 2) == (column < pattern.width / 2);
    return pixel_of(is_first ? pattern.first : pattern.second);
  };
}

// Coordinates of a pixel from -1 to 1, right and up.
glm::dvec2 centred(const TexturePattern& pattern, uint32_t row, uint32_t column) {
  return {2.0 * column / std::max(1.0, pattern.width - 1.0) - 1,
          1 - 2.0 * row / std::max(1.0, pattern.height - 1.0)};
}

}  // namespace

std::vector<uint8_t> draw_pattern(const TexturePattern& pattern) {
  if (pattern.kind == "checker") return draw(pattern, checker(pattern));
  if (pattern.kind == "flat")
    return draw(pattern, [&](uint32_t, uint32_t) { return pixel_of(pattern.first); });
  if (pattern.kind != "gradient") return draw(pattern, nullptr);
  return draw(pattern, [&](uint32_t row, uint32_t column) {
    return pixel_of(blend(pattern.second, pattern.first, 2 * glm::length(centred(pattern, row, column)) - 1));
  });
}

std::vector<uint8_t> draw_face(const TexturePattern& pattern, size_t face) {
  constexpr size_t kUp = 2, kDown = 3;
  if (pattern.kind == "checker") return draw(pattern, checker(pattern));
  if (pattern.kind == "flat")
    return draw(pattern,
                [&](uint32_t, uint32_t) { return pixel_of(face == kDown ? pattern.second : pattern.first); });
  if (pattern.kind != "gradient") return draw(pattern, nullptr);
  // By the elevation: the first colour is at the zenith.
  return draw(pattern, [&](uint32_t row, uint32_t column) {
    const glm::dvec2 at = centred(pattern, row, column);
    const double from_axis = std::atan(glm::length(at));
    const double quarter = std::numbers::pi / 2;
    const double elevation = face == kUp     ? quarter - from_axis
                             : face == kDown ? from_axis - quarter
                                             : std::atan2(at.y, std::hypot(1.0, at.x));
    return pixel_of(blend(pattern.first, pattern.second, elevation / quarter));
  });
}

glm::vec3 mean_of_cube(const TexturePattern& pattern) {
  const glm::dvec3 first(linear_from_srgb(glm::vec3(pattern.first))),
      second(linear_from_srgb(glm::vec3(pattern.second))),
      mark(linear_from_srgb(glm::vec3(pattern.mark_color)));
  // The lower side of a flat cube has the second colour; the other patterns have as much of both.
  glm::dvec3 mean = 0.5 * (first + second);
  if (pattern.kind == "flat") mean = (5.0 * first + second) / 6.0;
  if (pattern.kind.empty() || pattern.kind == "none") mean = glm::dvec3(0);
  const double side = std::max(1.0, static_cast<double>(pattern.width));
  double marked = 0;
  if (pattern.mark == "edge") marked = std::min(1.0, 4 / side);
  if (pattern.mark == "cross") marked = std::min(1.0, 2 / side);
  if (pattern.mark == "random") marked = std::clamp(pattern.random, 0.0, 1.0);
  return glm::vec3(glm::mix(mean, mark, marked));
}

}  // namespace fire3dv::convert
