#include "renderer/scene/textures/environment_sun.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "base/parallel.h"

namespace fire3dv::scene {
namespace {

// Surroundings of the brightest texel, whose median radiance a sun exceeds by this factor.
constexpr float kInnerRing_rad = 0.07f, kOuterRing_rad = 0.14f;  // 4 and 8 degrees
constexpr float kLeastContrast = 8, kLobeContrast = 4;
// A lobe reaches down to this share of its brightest texel, where its surroundings are darker.
constexpr float kLobeEdge = 1.0f / 256;

float texel_luminance(const glm::vec3& color) {
  return glm::dot(color, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

// Geometry of the texels of an equirectangular image. Values are without the image's scale.
class Texels {
 public:
  explicit Texels(const EnvironmentImage& image) : image_(image), row_solid_angles_(image.height) {
    for (uint32_t y = 0; y < image.height; ++y)
      row_solid_angles_[y] = 2 * std::numbers::pi / image.width *
                             (std::cos(y * std::numbers::pi / image.height) -
                              std::cos((y + 1) * std::numbers::pi / image.height));
  }

  uint32_t index(uint32_t x, uint32_t y) const { return y * image_.width + x; }
  uint32_t row(uint32_t texel) const { return texel / image_.width; }
  glm::vec3 color(uint32_t texel) const { return unpack_rgb9e5(image_.rgb9e5[texel]); }
  double solid_angle_sr(uint32_t texel) const { return row_solid_angles_[row(texel)]; }
  glm::vec3 direction(uint32_t texel) const {
    return environment_direction(
        (static_cast<float>(texel % image_.width) + 0.5f) / static_cast<float>(image_.width),
        (static_cast<float>(row(texel)) + 0.5f) / static_cast<float>(image_.height));
  }
  // Mean square distance that bilinear filtering adds around a texel's centre: a tent along each axis.
  double filtered_square(uint32_t texel) const {
    const double tall = std::numbers::pi / image_.height;
    const double wide = 2 * std::numbers::pi / image_.width * std::sin((row(texel) + 0.5) * tall);
    return (tall * tall + wide * wide) / 6;
  }
  // The eight texels around it, across the seam and the poles.
  std::array<uint32_t, 8> neighbours(uint32_t texel) const {
    const uint32_t width = image_.width, x = texel % width, y = row(texel);
    std::array<uint32_t, 8> around{};
    size_t count = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      const bool crosses_pole = (dy < 0 && y == 0) || (dy > 0 && y + 1 == image_.height);
      const uint32_t at_y = crosses_pole ? y : static_cast<uint32_t>(static_cast<int>(y) + dy);
      for (const uint32_t dx : {width - 1, 0u, 1u}) {
        if (dy == 0 && dx == 0) continue;
        around[count++] = index((x + dx + (crosses_pole ? width / 2 : 0)) % width, at_y);
      }
    }
    return around;
  }

 private:
  const EnvironmentImage& image_;
  std::vector<double> row_solid_angles_;
};

// The first of the brightest texels.
uint32_t brightest_texel(const EnvironmentImage& image, const Texels& texels) {
  std::vector<std::pair<float, uint32_t>> of_rows(image.height, {-1.0f, 0});
  parallel_for(image.height, [&](size_t y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      const uint32_t texel = texels.index(x, static_cast<uint32_t>(y));
      const float value = texel_luminance(texels.color(texel));
      if (value > of_rows[y].first) of_rows[y] = {value, texel};
    }
  });
  return std::max_element(of_rows.begin(), of_rows.end(),
                          [](const auto& a, const auto& b) { return a.first < b.first; })
      ->second;
}

float median_of(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Median luminance of a ring around the texel.
float luminance_around(const EnvironmentImage& image, const Texels& texels, uint32_t center) {
  const glm::vec3 axis = texels.direction(center);
  const float inner = std::cos(kInnerRing_rad), outer = std::cos(kOuterRing_rad);
  const uint32_t reach =
      static_cast<uint32_t>(static_cast<double>(kOuterRing_rad) / std::numbers::pi * image.height) + 1;
  const uint32_t first = texels.row(center) - std::min(texels.row(center), reach);
  const uint32_t last = std::min(texels.row(center) + reach, image.height - 1);
  const uint32_t step = std::max(image.height / 512, 1u);
  std::vector<float> values;
  for (uint32_t y = first; y <= last; y += step) {
    for (uint32_t x = 0; x < image.width; x += step) {
      const uint32_t texel = texels.index(x, y);
      const float cosine = glm::dot(texels.direction(texel), axis);
      if (cosine <= inner && cosine >= outer) values.push_back(texel_luminance(texels.color(texel)));
    }
  }
  return median_of(std::move(values));
}

struct Lobe {
  std::vector<uint32_t> texels, ring;  // ring: the texels around it
};

// Texels above the threshold that are connected with the first one. Nothing if they are too large for a sun.
std::optional<Lobe> grow_lobe(const EnvironmentImage& image, const Texels& texels, uint32_t first,
                              float threshold) {
  const double max_solid_angle =
      2 * std::numbers::pi * (1 - std::cos(static_cast<double>(kMaxSunRadius_rad)));
  std::vector<bool> is_seen(image.rgb9e5.size());
  Lobe lobe;
  lobe.texels.push_back(first);
  is_seen[first] = true;
  double solid_angle = 0;
  for (size_t next = 0; next < lobe.texels.size(); ++next) {
    const uint32_t texel = lobe.texels[next];
    solid_angle += texels.solid_angle_sr(texel);
    if (solid_angle > max_solid_angle) return std::nullopt;
    for (const uint32_t beside : texels.neighbours(texel)) {
      if (is_seen[beside]) continue;
      is_seen[beside] = true;
      (texel_luminance(texels.color(beside)) > threshold ? lobe.texels : lobe.ring).push_back(beside);
    }
  }
  return lobe;
}

glm::vec3 median_color(const Texels& texels, const std::vector<uint32_t>& of) {
  glm::vec3 result(0);
  for (int c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (const uint32_t texel : of) values.push_back(texels.color(texel)[c]);
    result[c] = median_of(std::move(values));
  }
  return result;
}

// Takes the lobe out of the image and sums its light. Nothing if the lobe is too wide.
std::optional<SplitEnvironment> take_out(const EnvironmentImage& image, const Texels& texels,
                                         const Lobe& lobe) {
  const glm::vec3 surroundings = median_color(texels, lobe.ring);
  std::vector<std::pair<uint32_t, uint32_t>> replaced;
  glm::dvec3 light(0), center(0);
  for (const uint32_t texel : lobe.texels) {
    const glm::vec3 color = texels.color(texel);
    const uint32_t packed = pack_rgb9e5(glm::min(color, surroundings));
    replaced.emplace_back(texel, packed);
    const glm::dvec3 taken = texels.solid_angle_sr(texel) * glm::dvec3(color - unpack_rgb9e5(packed));
    light += taken;
    center += static_cast<double>(texel_luminance(glm::vec3(taken))) * glm::dvec3(texels.direction(texel));
  }
  const double weight = static_cast<double>(texel_luminance(glm::vec3(light)));
  if (!(weight > 0) || !(glm::length(center) > 0)) return std::nullopt;
  const glm::dvec3 to_sun = glm::normalize(center);
  double square = 0;
  for (const auto& [texel, packed] : replaced) {
    const glm::dvec3 taken =
        texels.solid_angle_sr(texel) * glm::dvec3(texels.color(texel) - unpack_rgb9e5(packed));
    const double chord = glm::distance(glm::dvec3(texels.direction(texel)), to_sun);
    square += static_cast<double>(texel_luminance(glm::vec3(taken))) *
              (chord * chord + texels.filtered_square(texel));
  }
  SplitEnvironment split;
  split.sun.angular_radius_rad = static_cast<float>(std::sqrt(2 * square / weight));
  if (split.sun.angular_radius_rad > kMaxSunRadius_rad) return std::nullopt;
  split.sun.to_sun = glm::vec3(to_sun);
  split.sun.illuminance_lux = glm::vec3(light) * image.scale;
  split.rest = image;
  for (const auto& [texel, packed] : replaced) split.rest.rgb9e5[texel] = packed;
  return split;
}

// Illuminance of a surface with this normal, as luminance.
double facing_illuminance(const EnvironmentImage& image, const glm::vec3& normal) {
  const Texels texels(image);
  std::vector<double> rows(image.height);
  parallel_for(image.height, [&](size_t y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      const uint32_t texel = texels.index(x, static_cast<uint32_t>(y));
      const float cosine = glm::dot(texels.direction(texel), normal);
      if (cosine > 0) rows[y] += static_cast<double>(cosine * texel_luminance(texels.color(texel)));
    }
    rows[y] *= texels.solid_angle_sr(texels.index(0, static_cast<uint32_t>(y)));
  });
  double sum = 0;
  for (const double row : rows) sum += row;
  return sum * static_cast<double>(image.scale);
}

}  // namespace

std::optional<SplitEnvironment> split_sun(const EnvironmentImage& image) {
  if (image.rgb9e5.empty()) return std::nullopt;
  const Texels texels(image);
  const uint32_t first = brightest_texel(image, texels);
  const float most = texel_luminance(texels.color(first));
  const float around = luminance_around(image, texels, first);
  if (!(most > kLeastContrast * around)) return std::nullopt;
  // The lowest threshold whose lobe is small enough: a glow around the sun stays in the image.
  for (float threshold = std::max(kLobeEdge * most, kLobeContrast * around); threshold < most;
       threshold *= 2) {
    const std::optional<Lobe> lobe = grow_lobe(image, texels, first, threshold);
    if (!lobe) continue;
    std::optional<SplitEnvironment> split = take_out(image, texels, *lobe);
    if (!split) continue;
    const double light = static_cast<double>(texel_luminance(split->sun.illuminance_lux));
    const double rest = facing_illuminance(split->rest, split->sun.to_sun);
    split->sun.share_of_illuminance = static_cast<float>(light / (light + rest));
    if (split->sun.share_of_illuminance < kMinSunShare) return std::nullopt;
    return split;
  }
  return std::nullopt;
}

Light light_of(const EnvironmentSun& sun) {
  Light light;
  light.name = "environment sun";
  light.type = LightType::directional;
  light.color = sun.illuminance_lux;
  light.intensity = 1;
  light.angular_radius_rad = sun.angular_radius_rad;
  return light;
}

glm::vec3 world_direction(const EnvironmentSun& sun, float rotation_rad) {
  const float c = std::cos(rotation_rad), s = std::sin(rotation_rad);
  const glm::vec3& d = sun.to_sun;
  return {c * d.x + s * d.z, d.y, c * d.z - s * d.x};
}

std::string describe(const EnvironmentSun& sun) {
  constexpr float kDegrees = 57.2957795f;
  char text[160];
  std::snprintf(text, sizeof(text), "%.1f degrees above the horizon, %.2g degrees wide, %.0f %% of the light",
                static_cast<double>(kDegrees * std::asin(std::clamp(sun.to_sun.y, -1.0f, 1.0f))),
                static_cast<double>(2 * kDegrees * sun.angular_radius_rad),
                static_cast<double>(100 * sun.share_of_illuminance));
  return text;
}

}  // namespace fire3dv::scene
