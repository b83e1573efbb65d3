#include "convert/mjcf/assets/sky_image.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

namespace fire3dv::convert {
namespace {

constexpr uint32_t kMinRows = 64, kMaxRows = 1024, kEvenColumns = 8;

struct FacePoint {
  size_t face = 0;
  glm::dvec2 at{0};  // from 0 to 1, from the upper left corner
};

// The selection of faces of OpenGL's cube maps.
FacePoint face_point(const glm::dvec3& direction) {
  const glm::dvec3 size = glm::abs(direction);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const bool is_negative = direction[axis] < 0;
  const double sign = is_negative ? -1 : 1;
  glm::dvec2 at(0);
  if (axis == 0) at = {-sign * direction.z, -direction.y};
  if (axis == 1) at = {direction.x, sign * direction.z};
  if (axis == 2) at = {sign * direction.x, -direction.y};
  return {static_cast<size_t>(2 * axis + (is_negative ? 1 : 0)), 0.5 + 0.5 * at / size[axis]};
}

// Bilinear, within the face.
glm::dvec3 color_at(const PngPixels& face, const glm::dvec2& at) {
  if (face.rgb.empty()) return glm::dvec3(0);
  const glm::dvec2 last(face.width - 1.0, face.height - 1.0);
  const glm::dvec2 texel = glm::clamp(at * glm::dvec2(face.width, face.height) - 0.5, glm::dvec2(0), last);
  const glm::uvec2 low(texel), high(glm::min(glm::floor(texel) + 1.0, last));
  const auto pixel = [&](uint32_t x, uint32_t y) {
    const size_t first = 3 * (size_t{y} * face.width + x);
    return glm::dvec3(face.rgb[first], face.rgb[first + 1], face.rgb[first + 2]);
  };
  const glm::dvec2 share = texel - glm::dvec2(low);
  return glm::mix(glm::mix(pixel(low.x, low.y), pixel(high.x, low.y), share.x),
                  glm::mix(pixel(low.x, high.y), pixel(high.x, high.y), share.x), share.y);
}

}  // namespace

PngPixels sky_of(const CubeFaces& faces, bool is_even) {
  uint32_t side = 0;
  for (const PngPixels& face : faces) side = std::max(side, std::min(face.height, kMaxRows));
  PngPixels sky;
  sky.height = std::clamp(2 * side, kMinRows, kMaxRows);
  sky.width = is_even ? kEvenColumns : 2 * sky.height;
  sky.rgb.reserve(size_t{3} * sky.width * sky.height);
  for (uint32_t row = 0; row < sky.height; ++row) {
    const double angle = (row + 0.5) / sky.height * std::numbers::pi;  // from the zenith
    for (uint32_t column = 0; column < sky.width; ++column) {
      const double turn = ((column + 0.5) / sky.width - 0.5) * 2 * std::numbers::pi;
      // An even sky is taken along one meridian, whose colours are those of all.
      const double along = is_even ? 0 : turn;
      const FacePoint point = face_point(
          {std::sin(angle) * std::sin(along), std::cos(angle), -std::sin(angle) * std::cos(along)});
      const glm::dvec3 color = color_at(faces[point.face], point.at);
      for (int c = 0; c < 3; ++c)
        sky.rgb.push_back(static_cast<uint8_t>(std::lround(std::clamp(color[c], 0.0, 255.0))));
    }
  }
  return sky;
}

}  // namespace fire3dv::convert
