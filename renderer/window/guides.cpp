#include "renderer/window/guides.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/window/measurement.h"
#include "renderer/window/overlay_colors.h"

namespace fire3dv::app {
namespace {

using wire::Marker;
using wire::MarkerKind;

constexpr int kCells = 10;            // to each side of the centre
constexpr float kLift = 1.0f / 2000;  // in cells: a floor at height 0 does not hide the grid
constexpr uint32_t kGridColor = marker_color(0x808890, 0x70), kTenthColor = marker_color(0x808890, 0xd0);
constexpr uint32_t kFrustumColor = marker_color(0x4aa3df), kSelectedColor = marker_color(0xffa020);

float radius_m(const scene::Scene& scene) {
  const float radius = 0.5f * glm::length(scene.bounds_max - scene.bounds_min);
  constexpr float kMin = 1e-6f, kMax = 1e12f;
  return radius >= kMin && radius <= kMax ? radius : 1;
}

void add_line(Marker& marker, const glm::vec3& from, const glm::vec3& to, uint32_t color) {
  for (const glm::vec3& end : {from, to}) {
    marker.positions.push_back(marker_point(end));
    marker.colors.push_back(color);
  }
}

Marker text_at(const glm::vec3& at, std::string text, uint32_t color, float display_scale) {
  Marker marker;
  marker.kind = MarkerKind::texts;
  marker.width = 12 * display_scale;
  marker.positions = {marker_point(at)};
  marker.colors = {color};
  marker.texts = {std::move(text)};
  return marker;
}

// A name as a marker may have it: one line of printable characters.
std::string label_of(const std::string& name) {
  std::string label = name.substr(0, 64);
  // A cut character would be no UTF-8.
  while (label.size() < name.size() && !label.empty() &&
         (static_cast<uint8_t>(name[label.size()]) & 0xc0) == 0x80)
    label.pop_back();
  for (char& c : label) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return label;
}

}  // namespace

float grid_cell_m(const scene::Scene& scene) {
  const float wanted = radius_m(scene) / 4;
  const float power = std::pow(10.0f, std::floor(std::log10(wanted)));
  for (const float step : {5.0f, 2.0f}) {
    if (step * power <= wanted * 1.0001f) return step * power;
  }
  return power;
}

std::vector<Marker> ground_grid(const scene::Scene& scene, float display_scale) {
  const float cell = grid_cell_m(scene);
  glm::vec3 center = 0.5f * (scene.bounds_min + scene.bounds_max) / cell;
  // Beyond this, neighbouring lines are one in single precision.
  constexpr float kMaxCells = 1e6f;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(center[axis]) <= kMaxCells)) center[axis] = 0;
  }
  const int x = static_cast<int>(std::round(center.x)), z = static_cast<int>(std::round(center.z));
  Marker lines;
  lines.kind = MarkerKind::lines;
  lines.width = 1.2f * display_scale;
  const auto at = [&](int column, int row) {
    return glm::vec3(static_cast<float>(column), kLift, static_cast<float>(row)) * cell;
  };
  const auto color_of = [](int index, uint32_t axis_color) {
    return index == 0 ? axis_color : index % 10 == 0 ? kTenthColor : kGridColor;
  };
  for (int i = -kCells; i <= kCells; ++i) {
    add_line(lines, at(x - kCells, z + i), at(x + kCells, z + i), color_of(z + i, kAxisColors[0]));
    add_line(lines, at(x + i, z - kCells), at(x + i, z + kCells), color_of(x + i, kAxisColors[2]));
  }
  Marker axes;
  axes.kind = MarkerKind::axes;
  axes.flags = wire::kMarkerOverlaid;
  axes.width = 3 * display_scale;
  axes.positions = {{0, 0, 0}};
  axes.sizes = {{cell, cell, cell}};
  return {std::move(lines), std::move(axes),
          text_at({cell, 0, 0}, "\n" + metres_text(cell), kAxisColors[0], display_scale)};
}

float frustum_depth_m(const scene::Scene& scene) {
  return 0.15f * radius_m(scene);
}

std::vector<Marker> camera_frustum(const scene::Camera& camera, const std::string& name, float depth_m,
                                   float image_aspect, bool is_selected, float display_scale) {
  const float near = std::min(camera.near_m, depth_m);
  const float far = camera.far_m > 0 ? std::clamp(camera.far_m, near, depth_m) : depth_m;
  glm::vec2 half = camera.half_extent_m;  // at the far end
  glm::vec2 center(0);                    // of the image, at the far end
  float share = 1;                        // of both at the near end
  if (!camera.orthographic) {
    constexpr float kWidest_rad = 3;
    half.y = far * std::tan(0.5f * std::clamp(camera.vertical_fov_rad, 0.0f, kWidest_rad));
    half.x = half.y * (camera.aspect > 0 ? camera.aspect : camera.pixel_aspect * image_aspect);
    // The image's centre lies opposite to the principal point; y is up here, and down in images.
    center = glm::vec2(-camera.pixel_aspect, 1) * camera.principal_point * (2 * half.y);
    share = 0;
  }
  const float near_z = camera.orthographic ? -near : 0;
  const std::array<glm::vec2, 4> corners{glm::vec2(-1, -1), {1, -1}, {1, 1}, {-1, 1}};
  Marker lines;
  lines.kind = MarkerKind::lines;
  lines.width = 1.5f * display_scale;
  const uint32_t color = is_selected ? kSelectedColor : kFrustumColor;
  for (size_t i = 0; i < corners.size(); ++i) {
    const glm::vec2 a = center + corners[i] * half, b = center + corners[(i + 1) % corners.size()] * half;
    add_line(lines, {a, -far}, {b, -far}, color);
    add_line(lines, {share * a, near_z}, {a, -far}, color);
    if (camera.orthographic) add_line(lines, {a, near_z}, {b, near_z}, color);
  }
  const glm::vec3 middle(center, -far), left = middle + glm::vec3(-0.3f * half.x, 1.1f * half.y, 0),
                                        right = middle + glm::vec3(0.3f * half.x, 1.1f * half.y, 0),
                                        top = middle + glm::vec3(0, 1.5f * half.y, 0);
  add_line(lines, left, right, color);
  add_line(lines, right, top, color);
  add_line(lines, top, left, color);
  std::vector<Marker> markers{std::move(lines)};
  if (!name.empty()) markers.push_back(text_at({0, 0, near_z}, "\n" + label_of(name), color, display_scale));
  return markers;
}

}  // namespace fire3dv::app
