#include "renderer/state/draw_time/draw_work.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <optional>

#include "renderer/scene/model/math.h"

namespace fire3dv::state {
namespace {

constexpr size_t kSamples = 16;  // elements of a marker, triangles of a primitive

// Mean of a function of an index over evenly spaced samples.
template <typename Value>
double mean_of_samples(size_t count, const Value& value) {
  if (count == 0) return 0;
  const size_t samples = std::min(count, kSamples);
  double sum = 0;
  for (size_t i = 0; i < samples; ++i) sum += value(i * count / samples);
  return sum / static_cast<double>(samples);
}

// Projection of lengths and points into pixels.
class Projection {
 public:
  Projection(const WorkView& view, const glm::mat4& world_from_local)
      : clip_from_local_(view.clip_from_world * world_from_local), size_px_(view.size_px) {
    const auto length_of_row = [&](int row) {
      return glm::length(glm::vec3(view.clip_from_world[0][row], view.clip_from_world[1][row],
                                   view.clip_from_world[2][row]));
    };
    pixels_per_metre_ = 0.5f * std::max(size_px_.x * length_of_row(0), size_px_.y * length_of_row(1));
    scale_ = std::cbrt(std::abs(glm::determinant(glm::mat3(world_from_local))));
  }

  double view_pixels() const { return static_cast<double>(size_px_.x) * size_px_.y; }

  struct Point {
    glm::vec2 px{0};
    float w = 1;
  };
  // nullopt: behind the eye, or not finite.
  std::optional<Point> project(const glm::vec3& local) const {
    const glm::vec4 clip = clip_from_local_ * glm::vec4(local, 1);
    if (!(clip.w > 0)) return std::nullopt;
    const glm::vec2 px = (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * size_px_;
    if (!std::isfinite(px.x + px.y)) return std::nullopt;
    return Point{px, clip.w};
  }
  // Of a length in the local frame, at a point.
  float in_pixels(float length, const Point& at) const { return length * scale_ * pixels_per_metre_ / at.w; }

  // Pixels of the view inside a rectangle.
  double clipped_area(glm::vec2 low, glm::vec2 high) const {
    low = glm::clamp(low, glm::vec2(0), size_px_);
    high = glm::clamp(high, glm::vec2(0), size_px_);
    return std::max(0.0, static_cast<double>(high.x - low.x)) *
           std::max(0.0, static_cast<double>(high.y - low.y));
  }
  double clipped_square(const Point& centre, float side_px) const {
    return clipped_area(centre.px - 0.5f * side_px, centre.px + 0.5f * side_px);
  }
  // Of the box around points, widened by a margin. A polygon that crosses the plane of the eye may cover the
  // whole view.
  double clipped_box(std::initializer_list<glm::vec3> corners, float margin = 0,
                     bool is_margin_in_pixels = true) const {
    glm::vec2 low(1e30f), high(-1e30f);
    size_t behind = 0;
    for (const glm::vec3& corner : corners) {
      const std::optional<Point> point = project(corner);
      if (!point) {
        ++behind;
        continue;
      }
      const float margin_px = is_margin_in_pixels ? margin : in_pixels(margin, *point);
      low = glm::min(low, point->px - margin_px);
      high = glm::max(high, point->px + margin_px);
    }
    if (behind == corners.size()) return 0;
    return behind > 0 ? view_pixels() : clipped_area(low, high);
  }

 private:
  glm::mat4 clip_from_local_;
  glm::vec2 size_px_;
  float pixels_per_metre_ = 1, scale_ = 1;
};

glm::vec3 position_at(const wire::Marker& marker, size_t index) {
  const auto& position = marker.positions[std::min(index, marker.positions.size() - 1)];
  return {position[0], position[1], position[2]};
}

// Diameter of the sphere around an element with a size.
float diameter_at(const wire::Marker& marker, size_t index) {
  if (marker.sizes.empty()) return marker.width;
  const auto& size = marker.sizes[marker.sizes.size() == 1 ? 0 : std::min(index, marker.sizes.size() - 1)];
  return std::hypot(size[0], size[1], size[2]);
}

double element_fragments(const wire::Marker& marker, size_t index, const Projection& projection) {
  using wire::MarkerKind;
  const bool in_pixels = marker.width_unit == wire::MarkerUnit::pixels;
  const glm::vec3 position = position_at(marker, index);
  switch (marker.kind) {
    case MarkerKind::lines:
    case MarkerKind::arrows:  // heads are wide
      return projection.clipped_box({position_at(marker, index & ~size_t{1}), position_at(marker, index | 1)},
                                    marker.kind == MarkerKind::lines ? marker.width / 2 : marker.width,
                                    in_pixels) /
             2;  // two positions make an element
    case MarkerKind::line_strip:
      return projection.clipped_box({position, position_at(marker, index + 1)}, marker.width / 2, in_pixels);
    case MarkerKind::triangles: {
      const size_t first = index / 3 * 3;
      const double box = projection.clipped_box(
          {position_at(marker, first), position_at(marker, first + 1), position_at(marker, first + 2)});
      return box / 2 / 3;  // half of the box; three positions make an element
    }
    default:
      break;
  }
  const std::optional<Projection::Point> point = projection.project(position);
  if (!point) return 0;
  if (wire::has_sizes(marker.kind))
    return projection.clipped_square(*point, projection.in_pixels(diameter_at(marker, index), *point));
  const float width_px = in_pixels ? marker.width : projection.in_pixels(marker.width, *point);
  if (marker.kind != MarkerKind::texts) return projection.clipped_square(*point, width_px);
  // A glyph is about half as wide as high.
  const double glyphs = static_cast<double>(marker.texts[std::min(index, marker.texts.size() - 1)].size());
  return std::min(projection.view_pixels(), 0.5 * width_px * width_px) * glyphs;
}

}  // namespace

uint64_t text_bytes(const wire::Marker& marker) {
  uint64_t bytes = 0;
  for (const std::string& text : marker.texts) bytes += text.size();
  return bytes;
}

uint64_t max_marker_vertices(const wire::Marker& marker) {
  constexpr uint64_t kOfElement[] = {3,   3,  6,   45, 18, 36,
                                     144, 72, 180, 1,  6,  6};  // by kind, of more than 10,000
  static_assert(std::size(kOfElement) == wire::kMarkerKindCount);
  if (marker.kind == wire::MarkerKind::texts) return 6 * text_bytes(marker);
  const uint64_t finest = marker.positions.size() > 10'000 ? 1 : 12;
  return finest * kOfElement[static_cast<size_t>(marker.kind)] * marker.positions.size();
}

DrawWork marker_work(const wire::Marker& marker, const glm::mat4& world_from_marker, const WorkView& view) {
  const size_t count = marker.positions.size();
  if (count == 0 || (marker.kind == wire::MarkerKind::texts && marker.texts.empty())) return {};
  const Projection projection(view, world_from_marker);
  const double fragments =
      mean_of_samples(count, [&](size_t i) { return element_fragments(marker, i, projection); });
  return {static_cast<double>(max_marker_vertices(marker)), fragments * static_cast<double>(count), 0};
}

DrawWork mesh_work(const scene::Scene& scene, const scene::Mesh& mesh, const glm::mat4& world_from_node,
                   const WorkView& view) {
  const Projection projection(view, world_from_node);
  DrawWork work;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    const scene::Primitive& primitive = scene.primitives[p];
    work.vertices += primitive.index_count;
    if (primitive.topology != scene::Topology::triangles) continue;
    const uint32_t triangles = primitive.index_count / 3;
    const auto corner = [&](size_t index) {
      return scene.positions[primitive.first_vertex + scene.indices[primitive.first_index + index]];
    };
    const double fragments = mean_of_samples(triangles, [&](size_t i) {
      return projection.clipped_box({corner(3 * i), corner(3 * i + 1), corner(3 * i + 2)}) / 2;
    });
    work.fragments += fragments * triangles;
  }
  return work;
}

uint64_t triangle_count(const scene::Scene& scene, const scene::Mesh& mesh) {
  uint64_t triangles = 0;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    if (scene.primitives[p].topology == scene::Topology::triangles)
      triangles += scene.primitives[p].index_count / 3;
  }
  return triangles;
}

}  // namespace fire3dv::state
