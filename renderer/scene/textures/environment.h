// Environment map: incoming radiance by direction as an equirectangular image. The image centre is -Z (the
// view direction of a camera at rest), +X is to its right, +Y is at the top. A default image, and
// the readers of Radiance HDR (.hdr) and OpenEXR (.exr) files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::scene {

struct EnvironmentImage {
  uint32_t width = 0, height = 0;
  // RGB9E5: three 9-bit mantissas, a shared 5-bit exponent in the top bits. Top row first.
  std::vector<uint32_t> rgb9e5;
  float scale = 1;  // radiance = scale * texel, since the sun may exceed the format
};

// Largest value of the format.
constexpr float kMaxRgb9e5 = 65408;

// Negative values and NaN become 0; values above the maximum are clamped.
uint32_t pack_rgb9e5(glm::vec3 color);
glm::vec3 unpack_rgb9e5(uint32_t packed);

// Unit direction of image coordinates in 0..1, v from the top.
glm::vec3 environment_direction(float u, float v);

EnvironmentImage make_environment(uint32_t width, uint32_t height,
                                  const std::function<glm::vec3(const glm::vec3& direction)>& radiance);

// Default environment: a neutral studio with dim walls, a key panel above, a large fill panel and two narrow
// rim panels. Metals, glass and plastics have bright edges and dark walls to reflect.
EnvironmentImage studio_environment();
constexpr float kStudioMeanRadiance = 0.391f;

// Mean radiance over all directions, as luminance (Rec. 709).
float mean_radiance(const EnvironmentImage& image);

constexpr uint32_t kMaxEnvironmentWidth = 8192, kMaxEnvironmentHeight = 4096;

// Reads a Radiance HDR or an OpenEXR file; its first bytes tell which.
Result<EnvironmentImage> load_environment(const std::filesystem::path& path);

// True if the bytes begin as such a file.
bool is_radiance_file(std::span<const std::byte> bytes);
bool is_openexr_file(std::span<const std::byte> bytes);

// name: file name for errors.
Result<EnvironmentImage> decode_radiance_file(std::span<const std::byte> bytes, const std::string& name);
// Channels R, G and B, of a layer if there are no others, or Y alone. The image is the display window; where
// the data window leaves it open, it is black.
Result<EnvironmentImage> decode_openexr_file(std::span<const std::byte> bytes, const std::string& name);

// Scale of an image whose values are below `bound`, for values above the packed format (the sun).
float environment_scale(float bound);
Result<void> check_environment_size(uint64_t width, uint64_t height, const std::string& name);

}  // namespace fire3dv::scene
