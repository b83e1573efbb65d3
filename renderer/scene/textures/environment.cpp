#include "renderer/scene/textures/environment.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "base/parallel.h"

namespace fire3dv::scene {
namespace {

constexpr int kExponentBias = 15, kMantissaBits = 9, kMaxExponent = 31;
constexpr float kPi = 3.14159265358979f;

// Radiances of the studio.
constexpr float kStudioFloor = 0.22f, kStudioWall = 0.15f, kStudioCeiling = 0.30f;
constexpr float kStudioKey = 2.2f, kStudioFill = 0.7f, kStudioRim = 2.6f;

// Rectangle at unit distance, perpendicular to its direction.
struct Panel {
  glm::vec3 to_panel;                   // unit
  float half_width, half_height, edge;  // at unit distance; edge: width of the soft border
  float radiance;
};

float radiance_of_panel(const Panel& panel, const glm::vec3& direction) {
  const float facing = glm::dot(direction, panel.to_panel);
  if (facing <= 1e-3f) return 0;
  const glm::vec3 right = glm::normalize(glm::cross(glm::vec3(0, 1, 0), panel.to_panel));
  const glm::vec3 up = glm::cross(panel.to_panel, right);
  const auto inside = [&](const glm::vec3& axis, float half) {
    return 1 - glm::smoothstep(half - panel.edge, half + panel.edge,
                               std::abs(glm::dot(direction, axis)) / facing);
  };
  return panel.radiance * inside(right, panel.half_width) * inside(up, panel.half_height);
}

glm::vec3 studio_radiance(const glm::vec3& direction) {
  static const Panel kPanels[] = {
      {glm::normalize(glm::vec3(-0.30f, 0.80f, 0.52f)), 0.38f, 0.28f, 0.03f, kStudioKey},
      {glm::normalize(glm::vec3(0.90f, 0.25f, 0.45f)), 0.30f, 0.60f, 0.10f, kStudioFill},
      {glm::normalize(glm::vec3(-0.75f, 0.30f, -0.65f)), 0.10f, 0.55f, 0.03f, kStudioRim},
      {glm::normalize(glm::vec3(0.70f, 0.35f, -0.75f)), 0.10f, 0.45f, 0.03f, kStudioRim},
  };
  float radiance = direction.y > 0
                       ? glm::mix(kStudioWall, kStudioCeiling, glm::smoothstep(0.0f, 0.9f, direction.y))
                       : glm::mix(kStudioFloor, kStudioWall, glm::smoothstep(-0.5f, -0.02f, direction.y));
  for (const Panel& panel : kPanels) radiance += radiance_of_panel(panel, direction);
  return glm::vec3(radiance);
}

}  // namespace

uint32_t pack_rgb9e5(glm::vec3 color) {
  for (int c = 0; c < 3; ++c) color[c] = color[c] > 0 ? std::min(color[c], kMaxRgb9e5) : 0;  // NaN becomes 0
  const float largest = std::max({color.r, color.g, color.b});
  int exponent = std::max(-kExponentBias - 1, largest > 0 ? std::ilogb(largest) : -kExponentBias - 1) + 1 +
                 kExponentBias;
  float step = std::ldexp(1.0f, exponent - kExponentBias - kMantissaBits);
  if (std::lround(largest / step) == 1 << kMantissaBits) {  // rounding needs one more bit
    step *= 2;
    ++exponent;
  }
  exponent = std::min(exponent, kMaxExponent);
  const auto mantissa = [&](float value) { return static_cast<uint32_t>(std::lround(value / step)); };
  return mantissa(color.r) | mantissa(color.g) << 9 | mantissa(color.b) << 18 |
         static_cast<uint32_t>(exponent) << 27;
}

glm::vec3 unpack_rgb9e5(uint32_t packed) {
  const float step = std::ldexp(1.0f, static_cast<int>(packed >> 27) - kExponentBias - kMantissaBits);
  return step * glm::vec3(packed & 0x1ff, packed >> 9 & 0x1ff, packed >> 18 & 0x1ff);
}

glm::vec3 environment_direction(float u, float v) {
  const float around = (u - 0.5f) * 2 * kPi, down = v * kPi;
  return {std::sin(down) * std::sin(around), std::cos(down), -std::sin(down) * std::cos(around)};
}

EnvironmentImage make_environment(uint32_t width, uint32_t height,
                                  const std::function<glm::vec3(const glm::vec3& direction)>& radiance) {
  EnvironmentImage image;
  image.width = width;
  image.height = height;
  image.rgb9e5.reserve(size_t{width} * height);
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      image.rgb9e5.push_back(pack_rgb9e5(
          radiance(environment_direction((static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                                         (static_cast<float>(y) + 0.5f) / static_cast<float>(height)))));
    }
  }
  return image;
}

EnvironmentImage studio_environment() {
  return make_environment(512, 256, studio_radiance);
}

float mean_radiance(const EnvironmentImage& image) {
  std::vector<double> rows(image.height);
  parallel_for(image.height, [&](size_t y) {
    for (uint32_t x = 0; x < image.width; ++x)
      rows[y] +=
          glm::dot(unpack_rgb9e5(image.rgb9e5[y * image.width + x]), glm::vec3(0.2126f, 0.7152f, 0.0722f));
  });
  double sum = 0, weights = 0;
  for (uint32_t y = 0; y < image.height; ++y) {
    // Solid angle of a texel, up to a factor.
    const double weight = std::sin((y + 0.5) / image.height * static_cast<double>(kPi));
    sum += weight * rows[y];
    weights += weight * image.width;
  }
  return weights > 0 ? static_cast<float>(sum / weights) * image.scale : 0;
}

namespace {

// Limit of the file: OpenEXR's uncompressed floats of four channels, with room for more.
constexpr uint64_t kMaxBytes = 20ull * kMaxEnvironmentWidth * kMaxEnvironmentHeight;

}  // namespace

float environment_scale(float bound) {
  // The scale is limited to preserve precision of the rest.
  constexpr int kMaxScaleExponent = 10;
  if (!(bound > kMaxRgb9e5)) return 1;
  return std::ldexp(1.0f, std::min(std::ilogb(bound) - 15, kMaxScaleExponent));
}

Result<void> check_environment_size(uint64_t width, uint64_t height, const std::string& name) {
  if (width != 0 && height != 0 && width <= kMaxEnvironmentWidth && height <= kMaxEnvironmentHeight)
    return {};
  return Error{name + " is " + std::to_string(width) + " x " + std::to_string(height) +
               " pixels large; from 1 x 1 to " + std::to_string(kMaxEnvironmentWidth) + " x " +
               std::to_string(kMaxEnvironmentHeight) + " are read"};
}

Result<EnvironmentImage> load_environment(const std::filesystem::path& path) {
  Result<FileBytes> bytes = read_file(path, kMaxBytes);
  if (!bytes) return bytes.error();
  const std::string name = path.string();
  try {
    if (is_openexr_file(bytes->view())) return decode_openexr_file(bytes->view(), name);
    if (is_radiance_file(bytes->view())) return decode_radiance_file(bytes->view(), name);
    return Error{name +
                 " is neither a Radiance nor an OpenEXR image; use an equirectangular .hdr or .exr file"};
  } catch (const std::bad_alloc&) {
    return Error{name + " does not fit into memory; make the environment smaller"};
  }
}

}  // namespace fire3dv::scene
