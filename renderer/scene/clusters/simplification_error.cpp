#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/scene/clusters/level_steps.h"
#include "renderer/scene/model/scene_fields.h"

namespace fire3dv::scene {
namespace {

// Uniform grid of triangles for nearest-point queries. Not thread-safe, since queries mark visited triangles.
class TriangleGrid {
 public:
  TriangleGrid(std::span<const glm::vec3> positions, std::span<const uint32_t> indices);

  float cell() const { return cell_; }

  // Calls visitor(triangle) once per triangle whose cell is closer than enough(), in rings of cells from near
  // to far. enough() is evaluated again for each ring.
  template <typename Visitor, typename Enough>
  void visit(const glm::vec3& point, const Visitor& visitor, const Enough& enough) {
    ++visit_;
    const glm::ivec3 center = cell_at(point);
    // Distance to the border of the cell; points outside the grid are farther from all triangles.
    const glm::vec3 inside = point - low_ - glm::vec3(center) * cell_;
    const glm::vec3 to_border = glm::max(glm::min(inside, cell_ - inside), glm::vec3(0));
    const float border = std::min(to_border.x, std::min(to_border.y, to_border.z));
    for (int ring = 0; ring < kSide; ++ring) {
      if (ring > 0 && border + static_cast<float>(ring - 1) * cell_ > enough()) return;
      const glm::ivec3 low = glm::max(center - ring, glm::ivec3(0)),
                       high = glm::min(center + ring, size_ - 1);
      for (int z = low.z; z <= high.z; ++z) {
        for (int y = low.y; y <= high.y; ++y) {
          const bool face =
              z == center.z - ring || z == center.z + ring || y == center.y - ring || y == center.y + ring;
          for (int x = low.x; x <= high.x; ++x) {
            if (face || x == center.x - ring || x == center.x + ring) visit_cell({x, y, z}, visitor);
          }
        }
      }
    }
  }

 private:
  static constexpr int kSide = 24;  // maximum cells per side

  glm::ivec3 cell_at(const glm::vec3& point) const {
    return glm::clamp(glm::ivec3((point - low_) * inverse_cell_), glm::ivec3(0), size_ - 1);
  }
  size_t index(const glm::ivec3& cell) const {
    return static_cast<size_t>((cell.z * size_.y + cell.y) * size_.x + cell.x);
  }
  template <typename Visitor>
  void visit_cell(const glm::ivec3& cell, const Visitor& visitor) {
    const size_t i = index(cell);
    for (uint32_t t = first_[i]; t < first_[i + 1]; ++t) {
      uint32_t& seen = seen_[triangles_[t]];
      if (seen == visit_) continue;
      seen = visit_;
      visitor(triangles_[t]);
    }
  }

  glm::vec3 low_{0};
  float cell_ = 1, inverse_cell_ = 1;
  glm::ivec3 size_{1};
  std::vector<uint32_t> first_, triangles_, seen_;
  uint32_t visit_ = 0;
};

TriangleGrid::TriangleGrid(std::span<const glm::vec3> positions, std::span<const uint32_t> indices) {
  const size_t count = indices.size() / 3;
  glm::vec3 low(INFINITY), high(-INFINITY);
  for (uint32_t index : indices) {
    low = glm::min(low, positions[index]);
    high = glm::max(high, positions[index]);
  }
  if (count == 0) low = high = glm::vec3(0);
  low_ = low;
  // Cells per side: a surface of n triangles spans about sqrt(n / 2) of them.
  const glm::vec3 extent = high - low;
  const float longest = std::max(extent.x, std::max(extent.y, extent.z));
  const float across = std::clamp(std::sqrt(0.5f * static_cast<float>(count)), 1.0f, kSide - 1.0f);
  cell_ = longest > 0 ? longest / across : 1.0f;
  inverse_cell_ = 1 / cell_;
  if (!std::isfinite(inverse_cell_)) cell_ = inverse_cell_ = 1;
  size_ = glm::clamp(glm::ivec3(extent * inverse_cell_) + 1, glm::ivec3(1), glm::ivec3(kSide));
  first_.assign(index(size_ - 1) + 2, 0);
  seen_.assign(count, 0);
  auto each_cell = [&](size_t triangle, auto&& use) {
    const glm::vec3 a = positions[indices[3 * triangle]], b = positions[indices[3 * triangle + 1]],
                    c = positions[indices[3 * triangle + 2]];
    const glm::ivec3 from = cell_at(glm::min(a, glm::min(b, c))), to = cell_at(glm::max(a, glm::max(b, c)));
    for (int z = from.z; z <= to.z; ++z) {
      for (int y = from.y; y <= to.y; ++y) {
        for (int x = from.x; x <= to.x; ++x) use(index({x, y, z}));
      }
    }
  };
  for (size_t t = 0; t < count; ++t) each_cell(t, [&](size_t cell) { ++first_[cell + 1]; });
  for (size_t cell = 0; cell + 1 < first_.size(); ++cell) first_[cell + 1] += first_[cell];
  triangles_.resize(first_.back());
  std::vector<uint32_t> next = first_;
  for (size_t t = 0; t < count; ++t) {
    each_cell(t, [&](size_t cell) { triangles_[next[cell]++] = static_cast<uint32_t>(t); });
  }
}

constexpr float kSeen = 0.06f;
// Normals and colours with a smaller difference are indistinguishable in an 8-bit image.
constexpr float kUnseen = 0.01f;

// Barycentric coordinates of the closest point of a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
glm::vec3 closest_on_triangle(const glm::vec3& p, const glm::vec3& a, const glm::vec3& b,
                              const glm::vec3& c) {
  const glm::vec3 ab = b - a, ac = c - a, ap = p - a;
  const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const glm::vec3 bp = p - b;
  const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const float v = d1 > d3 ? d1 / (d1 - d3) : 0;
    return {1 - v, v, 0};
  }
  const glm::vec3 cp = p - c;
  const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const float w = d2 > d6 ? d2 / (d2 - d6) : 0;
    return {1 - w, 0, w};
  }
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const float sum = (d4 - d3) + (d5 - d6), w = sum > 0 ? (d4 - d3) / sum : 0;
    return {0, 1 - w, w};
  }
  const float inverse = 1 / (va + vb + vc);
  return {1 - (vb + vc) * inverse, vb * inverse, vc * inverse};
}

glm::vec3 unit(const glm::vec3& v) {
  const float size2 = glm::dot(v, v);
  return size2 > 0 ? v / std::sqrt(size2) : glm::vec3(0);
}

// Shaded attributes of a surface point.
struct SurfacePoint {
  glm::vec3 position{0}, normal{0}, tangent{0};
  float tangent_sign = 1;
  glm::vec2 uv0{0}, uv1{0};
  glm::vec4 color{0};
};

// A triangle of the simplified surface.
struct Facet {
  glm::vec3 corner[3];
  const VertexAttributes* at[3];
  glm::vec3 normal;  // not normalised
  glm::vec3 center;
  float reach;   // distance from the centre to the vertices
  float side_m;  // side of a square of twice its area
  float m_per_uv0, m_per_uv1;
};

SurfacePoint surface_point(const glm::vec3* const corner[3], const VertexAttributes* const at[3],
                           const glm::vec3& b) {
  SurfacePoint point;
  for (int i = 0; i < 3; ++i) {
    point.position += b[i] * *corner[i];
    point.normal += b[i] * at[i]->normal;
    point.tangent += b[i] * glm::vec3(at[i]->tangent);
    point.uv0 += b[i] * at[i]->uv0;
    point.uv1 += b[i] * at[i]->uv1;
    point.color += b[i] * at[i]->color;
  }
  point.normal = unit(point.normal);
  point.tangent = unit(point.tangent);
  point.tangent_sign = at[0]->tangent.w;
  return point;
}

// Largest surface length per unit of texture coordinate.
float m_per_uv(const Facet& facet, glm::vec2 VertexAttributes::*uv) {
  float longest = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const float uv_length = glm::length(facet.at[j]->*uv - facet.at[i]->*uv);
    const float length = glm::length(facet.corner[j] - facet.corner[i]);
    if (uv_length > 0) longest = std::max(longest, length / uv_length);
  }
  return longest;
}

float contrast_length(float difference, float side_m) {
  return difference > kUnseen ? side_m * std::sqrt((difference - kUnseen) / kSeen) : 0.0f;
}

class Comparison {
 public:
  Comparison(const SurfacePatch& original, std::span<const uint32_t> simplified, const UsedAttributes& used)
      : used_(used), grid_(original.positions, simplified) {
    facets_.resize(simplified.size() / 3);
    for (size_t t = 0; t < facets_.size(); ++t) {
      Facet& facet = facets_[t];
      for (size_t c = 0; c < 3; ++c) {
        facet.corner[c] = original.positions[simplified[3 * t + c]];
        facet.at[c] = &original.attributes[simplified[3 * t + c]];
      }
      const glm::vec3 n = glm::cross(facet.corner[1] - facet.corner[0], facet.corner[2] - facet.corner[0]);
      facet.normal = n;
      facet.center = (facet.corner[0] + facet.corner[1] + facet.corner[2]) / 3.0f;
      facet.reach = 0;
      for (const glm::vec3& corner : facet.corner)
        facet.reach = std::max(facet.reach, glm::length(corner - facet.center));
      facet.side_m = std::sqrt(glm::length(n));
      facet.m_per_uv0 = used.uv0 ? m_per_uv(facet, &VertexAttributes::uv0) : 0;
      facet.m_per_uv1 = used.uv1 ? m_per_uv(facet, &VertexAttributes::uv1) : 0;
    }
  }

  void take(const SurfacePoint& sample) {
    float best = INFINITY, distance = INFINITY, nearest = INFINITY, nearest_facing = INFINITY;
    grid_.visit(
        sample.position,
        [&](uint32_t t) {
          const Facet& facet = facets_[t];
          const glm::vec3 to_center = facet.center - sample.position;
          const float out_of_reach = best + facet.reach;
          if (glm::dot(to_center, to_center) > out_of_reach * out_of_reach) return;
          const glm::vec3 b =
              closest_on_triangle(sample.position, facet.corner[0], facet.corner[1], facet.corner[2]);
          const glm::vec3* const corner[3] = {&facet.corner[0], &facet.corner[1], &facet.corner[2]};
          const glm::vec3 q = b.x * *corner[0] + b.y * *corner[1] + b.z * *corner[2];
          const float here = glm::length(q - sample.position);
          nearest = std::min(nearest, here);
          if (glm::dot(sample.normal, facet.normal) > 0) nearest_facing = std::min(nearest_facing, here);
          if (here >= best) return;
          const float error = difference(sample, surface_point(corner, facet.at, b), facet, here);
          if (error >= best) return;
          best = error;
          distance = here;
        },
        // Bounds the search: distant similar points are no correspondences.
        [&] { return std::min(best, 2 * nearest + grid_.cell()); });
    error_.appearance = std::max(error_.appearance, best);
    // Only surfaces with the same facing count, since a thin plate has another side nearby.
    error_.surface = std::max(error_.surface, std::min(nearest_facing, distance));
  }

  LevelError error() const { return error_; }

 private:
  float difference(const SurfacePoint& a, const SurfacePoint& b, const Facet& facet, float distance) const {
    float length = distance;
    if (used_.uv0) length += glm::length(a.uv0 - b.uv0) * facet.m_per_uv0;
    if (used_.uv1) length += glm::length(a.uv1 - b.uv1) * facet.m_per_uv1;
    float contrast = 0;
    if (used_.normals) contrast += glm::length(a.normal - b.normal);
    if (used_.tangents) {
      contrast += a.tangent_sign == b.tangent_sign ? glm::length(a.tangent - b.tangent) : 2.0f;
    }
    if (used_.colors) {
      const glm::vec4 d = glm::abs(a.color - b.color);
      contrast += std::max(std::max(d.x, d.y), std::max(d.z, d.w));
    }
    return std::max(length, contrast_length(contrast, facet.side_m));
  }

  UsedAttributes used_;
  std::vector<Facet> facets_;
  TriangleGrid grid_;
  LevelError error_;
};

}  // namespace

UsedAttributes used_attributes(const Scene& scene, const Primitive& primitive) {
  const Material& m = scene.materials[primitive.material];
  UsedAttributes at;
  at.normals = primitive.lit && !m.unlit;
  at.tangents = at.normals && needs_tangents(m);
  at.uv0 = at.uv1 = false;
  visit_textures(m, [&](const TextureRef& texture) {
    if (texture.texture == kNone) return;
    at.uv0 |= texture.uv_set == 0;
    at.uv1 |= texture.uv_set == 1;
  });
  return at;
}

LevelError measure_error(const SurfacePatch& original, std::span<const uint32_t> simplified,
                         const UsedAttributes& used) {
  Comparison comparison(original, simplified, used);
  std::vector<bool> is_used(original.positions.size());
  for (uint32_t index : simplified) is_used[index] = true;
  // Samples are removed vertices and the centres of all original triangles, since remaining vertices may be
  // connected by other edges.
  for (size_t v = 0; v < original.positions.size(); ++v) {
    if (is_used[v]) continue;
    const VertexAttributes& a = original.attributes[v];
    comparison.take({original.positions[v], unit(a.normal), unit(glm::vec3(a.tangent)), a.tangent.w, a.uv0,
                     a.uv1, a.color});
  }
  for (size_t t = 0; t + 2 < original.indices.size(); t += 3) {
    const glm::vec3* corner[3];
    const VertexAttributes* at[3];
    for (size_t c = 0; c < 3; ++c) {
      corner[c] = &original.positions[original.indices[t + c]];
      at[c] = &original.attributes[original.indices[t + c]];
    }
    comparison.take(surface_point(corner, at, glm::vec3(1.0f / 3)));
  }
  return comparison.error();
}

}  // namespace fire3dv::scene
