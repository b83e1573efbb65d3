#include "convert/surfaces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/gtc/matrix_inverse.hpp>
#include <numbers>
#include <vector>

#include "base/text.h"

namespace fire3dv::convert {

namespace {

constexpr uint32_t kSlices = 48, kStacks = 24;

struct Direction {
  double cosine, sine;
};
// The last slice equals the first bit by bit, for watertight seams.
Direction slice(uint32_t i) {
  const double angle = 2 * std::numbers::pi * (i % kSlices) / kSlices;
  return {std::cos(angle), std::sin(angle)};
}

// Surface of rings with kSlices + 1 vertices each, from bottom to top.
class Rings {
 public:
  // normal_out, normal_up: normal in the plane of a slice.
  void add(double radius_x, double radius_y, double z, double normal_out, double normal_up, double v) {
    for (uint32_t i = 0; i <= kSlices; ++i) {
      const Direction d = slice(i);
      surface.positions.push_back(glm::dvec3(radius_x * d.cosine, radius_y * d.sine, z));
      surface.normals.push_back(
          glm::normalize(glm::dvec3(normal_out * d.cosine, normal_out * d.sine, normal_up)));
      surface.uvs.push_back(glm::dvec2(static_cast<double>(i) / kSlices, v));
    }
  }
  void join_last_two() {
    const auto upper = static_cast<uint32_t>(surface.positions.size()) - (kSlices + 1);
    const uint32_t lower = upper - (kSlices + 1);
    for (uint32_t i = 0; i < kSlices; ++i) {
      add_triangle(lower + i, lower + i + 1, upper + i + 1);
      add_triangle(lower + i, upper + i + 1, upper + i);
    }
  }
  Surface surface;

 private:
  void add_triangle(uint32_t a, uint32_t b, uint32_t c) {  // skips degenerate triangles where a ring is a
                                                           // point
    const auto& p = surface.positions;
    if (p[a] == p[b] || p[b] == p[c] || p[c] == p[a]) return;
    surface.indices.insert(surface.indices.end(), {a, b, c});
  }
};

// Latitude of a ring, exact at the poles and the equator.
Direction latitude(uint32_t ring, uint32_t rings) {
  if (ring == 0) return {0, -1};
  if (ring == rings) return {0, 1};
  const double angle = std::numbers::pi * (static_cast<double>(ring) / rings - 0.5);
  return {std::cos(angle), std::sin(angle)};
}

void add_disc(Surface& surface, double radius, double z, bool up) {
  const auto centre = static_cast<uint32_t>(surface.positions.size());
  surface.positions.push_back(glm::dvec3(0, 0, z));
  surface.uvs.push_back(glm::vec2(0.5f));
  for (uint32_t i = 0; i <= kSlices; ++i) {
    const Direction d = slice(i);
    surface.positions.push_back(glm::dvec3(radius * d.cosine, radius * d.sine, z));
    surface.uvs.push_back(glm::dvec2(0.5 + 0.5 * d.cosine, 0.5 - 0.5 * d.sine));
  }
  surface.normals.resize(surface.positions.size(), glm::vec3(0, 0, up ? 1 : -1));
  for (uint32_t i = 0; i < kSlices; ++i) {
    const uint32_t a = centre + 1 + i, b = a + 1;
    if (up)
      surface.indices.insert(surface.indices.end(), {centre, a, b});
    else
      surface.indices.insert(surface.indices.end(), {centre, b, a});
  }
}

}  // namespace

Surface box(const glm::dvec3& half) {
  Surface surface;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      glm::dvec3 normal(0), u(0), v(0);
      normal[axis] = side;
      u[(axis + 1) % 3] = side;  // u x v points outwards
      v[(axis + 2) % 3] = 1;
      const auto first = static_cast<uint32_t>(surface.positions.size());
      for (const glm::dvec2 corner : {glm::dvec2(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
        surface.positions.push_back((normal + corner.x * u + corner.y * v) * half);
        surface.normals.push_back(normal);
        surface.uvs.push_back(glm::dvec2(0.5 + 0.5 * corner.x, 0.5 - 0.5 * corner.y));
      }
      for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) surface.indices.push_back(first + i);
    }
  }
  return surface;
}

Surface ellipsoid(const glm::dvec3& radii) {
  Rings rings;
  for (uint32_t ring = 0; ring <= kStacks; ++ring) {
    const Direction at = latitude(ring, kStacks);
    rings.add(radii.x * at.cosine, radii.y * at.cosine, radii.z * at.sine, at.cosine, at.sine,
              1 - static_cast<double>(ring) / kStacks);
    if (ring > 0) rings.join_last_two();
  }
  // Normals scale inversely to positions.
  for (glm::vec3& normal : rings.surface.normals) normal = glm::normalize(glm::dvec3(normal) / radii);
  return std::move(rings.surface);
}

Surface cylinder(double radius, double half_length) {
  Rings rings;
  rings.add(radius, radius, -half_length, 1, 0, 1);
  rings.add(radius, radius, half_length, 1, 0, 0);
  rings.join_last_two();
  add_disc(rings.surface, radius, half_length, true);
  add_disc(rings.surface, radius, -half_length, false);
  return std::move(rings.surface);
}

Surface cone(double radius, double half_length) {
  Rings rings;
  rings.add(radius, radius, -half_length, 2 * half_length, radius, 1);
  rings.add(0, 0, half_length, 2 * half_length, radius, 0);
  rings.join_last_two();
  add_disc(rings.surface, radius, -half_length, false);
  return std::move(rings.surface);
}

Surface capsule(double radius, double half_length) {
  Rings rings;
  const double whole = 2 * (half_length + radius);
  const auto add_ring = [&](uint32_t ring, double center) {
    const Direction at = latitude(ring, kStacks);
    const double z = center + radius * at.sine;
    rings.add(radius * at.cosine, radius * at.cosine, z, at.cosine, at.sine, 0.5 - z / whole);
  };
  for (uint32_t ring = 0; ring <= kStacks / 2; ++ring) {
    add_ring(ring, -half_length);
    if (ring > 0) rings.join_last_two();
  }
  for (uint32_t ring = kStacks / 2; ring <= kStacks; ++ring) {
    add_ring(ring, half_length);
    rings.join_last_two();
  }
  return std::move(rings.surface);
}

Surface rectangle(double half_x, double half_y, const glm::dvec2& uv_repeats) {
  Surface surface;
  for (const glm::dvec2 corner : {glm::dvec2(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
    surface.positions.push_back(glm::dvec3(corner.x * half_x, corner.y * half_y, 0));
    surface.normals.emplace_back(0, 0, 1);
    surface.uvs.push_back(glm::dvec2(0.5 * corner.x, -0.5 * corner.y) * uv_repeats + 0.5);
  }
  surface.indices = {0, 1, 2, 0, 2, 3};
  return surface;
}

namespace {

// Half sides of an infinite plane, in scene extents: its middle is as precise as a small plane, and its edge
// is on the horizon.
constexpr double kInfinitePlaneExtents[] = {10, 50, 250, 1250};

// Places of vertices along an axis of a plane.
std::vector<double> plane_places(double half, double extent) {
  if (half > 0) return {-half, half};
  std::vector<double> places;
  for (const double extents : kInfinitePlaneExtents) {
    places.insert(places.begin(), -extents * extent);
    places.push_back(extents * extent);
  }
  return places;
}

}  // namespace

Surface horizon_plane(const glm::dvec2& half, double extent, const glm::dvec2& uv_repeats) {
  const std::vector<double> x = plane_places(half.x, extent), y = plane_places(half.y, extent);
  Surface surface;
  for (const double at_y : y) {
    for (const double at_x : x) {
      surface.positions.push_back(glm::dvec3(at_x, at_y, 0));
      surface.normals.emplace_back(0, 0, 1);
      surface.uvs.push_back(glm::dvec2(0.5 * at_x, -0.5 * at_y) * uv_repeats + 0.5);
    }
  }
  const auto columns = static_cast<uint32_t>(x.size()), rows = static_cast<uint32_t>(y.size());
  for (uint32_t row = 0; row + 1 < rows; ++row) {
    for (uint32_t column = 0; column + 1 < columns; ++column) {
      const uint32_t a = row * columns + column, b = a + columns;
      surface.indices.insert(surface.indices.end(), {a, a + 1, b + 1, a, b + 1, b});
    }
  }
  return surface;
}

void add_surface(Mesh& mesh, const Surface& surface, const glm::dmat4& mesh_from_surface, size_t material) {
  Surface* to = nullptr;
  for (Surface& other : mesh.surfaces) {
    if (other.material == material && other.normals.empty() == surface.normals.empty() &&
        other.uvs.empty() == surface.uvs.empty() && other.colors.empty() == surface.colors.empty())
      to = &other;
  }
  if (!to) {
    mesh.surfaces.emplace_back();
    to = &mesh.surfaces.back();
    to->material = material;
  }
  const auto first = static_cast<uint32_t>(to->positions.size());
  const glm::dmat3 linear(mesh_from_surface);
  const bool mirrored = glm::determinant(linear) < 0;
  const glm::dmat3 for_normals = glm::inverseTranspose(linear);
  for (const glm::vec3& position : surface.positions)
    to->positions.push_back(mesh_from_surface * glm::dvec4(glm::dvec3(position), 1));
  for (const glm::vec3& normal : surface.normals)
    to->normals.push_back(glm::normalize(for_normals * glm::dvec3(normal)));
  to->uvs.insert(to->uvs.end(), surface.uvs.begin(), surface.uvs.end());
  to->colors.insert(to->colors.end(), surface.colors.begin(), surface.colors.end());
  for (size_t i = 0; i + 3 <= surface.indices.size(); i += 3) {
    const uint32_t a = surface.indices[i], b = surface.indices[i + 1], c = surface.indices[i + 2];
    to->indices.insert(to->indices.end(),
                       {first + a, first + (mirrored ? c : b), first + (mirrored ? b : c)});
  }
}

glm::dmat4 matrix_of(const glm::dvec3& translation, const glm::dquat& rotation) {
  glm::dmat4 matrix = glm::mat4_cast(rotation);
  matrix[3] = glm::dvec4(translation, 1);
  return matrix;
}

namespace {

bool finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

size_t leave_out_broken_triangles(Surface& surface) {
  const size_t vertices = surface.positions.size();
  const size_t before = surface.indices.size();
  size_t count = 0;
  for (size_t i = 0; i + 3 <= before; i += 3) {
    bool whole = true;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t v = surface.indices[i + k];
      whole = whole && v < vertices && finite(surface.positions[v]);
    }
    if (!whole) continue;
    for (size_t k = 0; k < 3; ++k) surface.indices[count++] = surface.indices[i + k];
  }
  surface.indices.resize(count);
  return (before + 2) / 3 - count / 3;
}

bool move_lost_vertices(Surface& surface) {
  const glm::vec3* somewhere = nullptr;
  for (const glm::vec3& position : surface.positions) {
    if (finite(position)) somewhere = &position;
    if (somewhere) break;
  }
  bool any = false;
  for (glm::vec3& position : surface.positions) {
    if (finite(position)) continue;
    position = somewhere ? *somewhere : glm::vec3(0);  // unreferenced vertex; it only must not extend the
                                                       // bounds
    any = true;
  }
  return any;
}

size_t mend_normals(Surface& surface) {
  std::vector<size_t> broken;
  for (size_t v = 0; v < surface.normals.size(); ++v) {
    glm::vec3& normal = surface.normals[v];
    const float length = finite(normal) ? glm::length(normal) : 0;
    if (std::abs(length - 1) <= 1e-5f) continue;
    if (length > 1e-6f && std::isfinite(length)) {
      normal /= length;
    } else {
      normal = glm::vec3(0);
      broken.push_back(v);
    }
  }
  if (broken.empty()) return 0;
  std::vector<bool> is_broken(surface.normals.size());
  for (const size_t v : broken) is_broken[v] = true;
  for (size_t i = 0; i + 3 <= surface.indices.size(); i += 3) {
    const uint32_t* corner = &surface.indices[i];
    if (!is_broken[corner[0]] && !is_broken[corner[1]] && !is_broken[corner[2]]) continue;
    const glm::vec3& a = surface.positions[corner[0]];
    const glm::vec3 twice_area =
        glm::cross(surface.positions[corner[1]] - a, surface.positions[corner[2]] - a);
    for (size_t k = 0; k < 3; ++k)
      if (is_broken[corner[k]]) surface.normals[corner[k]] += twice_area;
  }
  for (const size_t v : broken) {
    const float length = glm::length(surface.normals[v]);
    surface.normals[v] =
        length > 0 && std::isfinite(length) ? surface.normals[v] / length : glm::vec3(0, 0, 1);
  }
  return broken.size();
}

}  // namespace

std::string repair(Surface& surface) {
  std::string said;
  const auto say = [&](const std::string& what) { said += (said.empty() ? "" : ", ") + what; };
  if (const size_t lost = leave_out_broken_triangles(surface))
    say(std::to_string(lost) + " triangles with positions that are not finite are left out");
  move_lost_vertices(surface);
  if (surface.normals.size() != surface.positions.size()) surface.normals.clear();
  if (surface.uvs.size() != surface.positions.size()) surface.uvs.clear();
  if (surface.colors.size() != surface.positions.size()) surface.colors.clear();
  if (const size_t mended = mend_normals(surface))
    say(std::to_string(mended) + " normals without a direction are made from triangles");
  if (surface.influences.size() != surface.positions.size()) surface.influences.clear();
  for (glm::vec2& uv : surface.uvs)
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) uv = glm::vec2(0);
  return said;
}

std::string describe_invisible(const Model& model) {
  std::string first;
  size_t count = 0;
  for (const Node& node : model.nodes) {
    if (!node.mesh) continue;
    const std::vector<Surface>& surfaces = model.meshes[*node.mesh].surfaces;
    const bool has_invisible = std::any_of(surfaces.begin(), surfaces.end(), [&](const Surface& surface) {
      const Material& material = model.materials[surface.material];
      return material.blended && material.base_color.a == 0;
    });
    if (has_invisible && count++ == 0) first = node.name;
  }
  if (count == 0) return {};
  return quote(first) + (count > 1 ? " and " + std::to_string(count - 1) + " more" : "") +
         (count > 1 ? " have" : " has") + " a colour of opacity 0, which is not drawn";
}

}  // namespace fire3dv::convert
