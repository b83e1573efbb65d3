#include "examples/common/mesh.h"

#include <algorithm>
#include <array>
#include <utility>

namespace examples {
namespace {

constexpr float kPi = 3.14159265f;
constexpr int kBevelSteps = 3;

// Point of a profile in a plane through the axis, with its normal.
struct ProfilePoint {
  float radius, height, normal_radius, normal_height;
};
using Profile = std::vector<ProfilePoint>;

void append_arc(Profile& profile, float center_radius, float center_height, float radius, float from_rad,
                float to_rad, int steps) {
  for (int i = 0; i <= steps; ++i) {
    const float angle = from_rad + (to_rad - from_rad) * static_cast<float>(i) / static_cast<float>(steps);
    const float c = std::cos(angle), s = std::sin(angle);
    const float from_axis = center_radius + radius * c;
    // Poles lie exactly on the axis, so that the mesh is watertight.
    profile.push_back({from_axis > 1e-6f * radius ? from_axis : 0.0f, center_height + radius * s, c, s});
  }
}

// Appends two triangles per cell of a vertex grid of (columns + 1) x (rows + 1) from `first`. Seen from
// outside, rows advance to the left of columns.
void append_grid(Mesh& mesh, uint32_t first, int columns, int rows) {
  const auto stride = static_cast<uint32_t>(columns + 1);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const uint32_t a = first + static_cast<uint32_t>(row) * stride + static_cast<uint32_t>(column);
      for (uint32_t index : {a, a + 1, a + stride + 1, a, a + stride + 1, a + stride})
        mesh.indices.push_back(index);
    }
  }
}

// Surface of revolution of a profile about Z, from the lowest point to the highest.
Mesh lathe(const Profile& profile, int segments, float from_rad = 0, float turn_rad = 2 * kPi) {
  Mesh mesh;
  float widest = 0, along = 0;
  for (const ProfilePoint& point : profile) widest = std::max(widest, point.radius);
  for (size_t i = 0; i < profile.size(); ++i) {
    const ProfilePoint& point = profile[i];
    if (i > 0)
      along += std::hypot(point.radius - profile[i - 1].radius, point.height - profile[i - 1].height);
    for (int k = 0; k <= segments; ++k) {
      const float angle = from_rad + turn_rad * static_cast<float>(k) / static_cast<float>(segments);
      // A full turn ends exactly where it began, for a watertight seam.
      const float place = turn_rad == 2 * kPi && k == segments ? from_rad : angle;
      const float c = std::cos(place), s = std::sin(place);
      mesh.vertices.push_back({{point.radius * c, point.radius * s, point.height},
                               {point.normal_radius * c, point.normal_radius * s, point.normal_height},
                               {-s, c, 0},
                               1,
                               (angle - from_rad) * widest,
                               along});
    }
  }
  append_grid(mesh, 0, segments, static_cast<int>(profile.size()) - 1);
  // Drops the degenerate triangles at the poles.
  std::vector<uint32_t> kept;
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Vec3 a = mesh.vertices[mesh.indices[i]].position, b = mesh.vertices[mesh.indices[i + 1]].position,
               c = mesh.vertices[mesh.indices[i + 2]].position;
    const Vec3 area = cross(b - a, c - a);
    if (dot(area, area) > 1e-20f)
      kept.insert(kept.end(), mesh.indices.begin() + static_cast<long>(i),
                  mesh.indices.begin() + static_cast<long>(i + 3));
  }
  mesh.indices = std::move(kept);
  return mesh;
}

Vec3 axis_vector(int axis) {
  return {axis == 0 ? 1.0f : 0.0f, axis == 1 ? 1.0f : 0.0f, axis == 2 ? 1.0f : 0.0f};
}

// Grid coordinates along a side, denser on bevels.
std::vector<float> grid_lines(float half, float bevel) {
  std::vector<float> lines;
  for (int i = 0; i <= kBevelSteps; ++i) {
    const float angle = kPi / 4 * (1 - static_cast<float>(i) / kBevelSteps);
    lines.push_back(-(half - bevel) - bevel * std::tan(angle));
  }
  const size_t count = lines.size();
  for (size_t i = 0; i < count; ++i) lines.push_back(-lines[count - 1 - i]);
  return lines;
}

// Face frames are right-handed: u x v points outwards.
void append_face(Mesh& mesh, Vec3 half, float bevel, int u_axis, int v_axis, float side) {
  const std::array<float, 3> halves = {half.x, half.y, half.z};
  const int n_axis = 3 - u_axis - v_axis;
  const Vec3 v_dir = axis_vector(v_axis), n_dir = axis_vector(n_axis) * side;
  const Vec3 u_dir = cross(v_dir, n_dir);
  const auto us = grid_lines(halves[static_cast<size_t>(u_axis)], bevel);
  const auto vs = grid_lines(halves[static_cast<size_t>(v_axis)], bevel);
  const auto first = static_cast<uint32_t>(mesh.vertices.size());
  for (float v : vs) {
    for (float u : us) {
      const Vec3 outer = u_dir * u + v_dir * v + n_dir * halves[static_cast<size_t>(n_axis)];
      const Vec3 inner = {std::clamp(outer.x, -half.x + bevel, half.x - bevel),
                          std::clamp(outer.y, -half.y + bevel, half.y - bevel),
                          std::clamp(outer.z, -half.z + bevel, half.z - bevel)};
      const Vec3 normal = normalized(outer - inner);
      const Vec3 tangent = normalized(u_dir - normal * dot(normal, u_dir));
      mesh.vertices.push_back({inner + normal * bevel, normal, tangent, 1, u, v});
    }
  }
  append_grid(mesh, first, static_cast<int>(us.size()) - 1, static_cast<int>(vs.size()) - 1);
}

}  // namespace

Mesh cylinder_mesh(float radius, float half_height, float bevel, int segments) {
  Profile profile{{0, -half_height, 0, -1}};
  append_arc(profile, radius - bevel, -half_height + bevel, bevel, -kPi / 2, 0, kBevelSteps);
  append_arc(profile, radius - bevel, half_height - bevel, bevel, 0, kPi / 2, kBevelSteps);
  profile.push_back({0, half_height, 0, 1});
  return lathe(profile, segments);
}

Mesh capsule_mesh(float radius, float half_straight, int segments) {
  const int steps = segments / 4;
  Profile profile;
  append_arc(profile, 0, -half_straight, radius, -kPi / 2, 0, steps);
  if (half_straight <= 0) profile.pop_back();  // the upper half adds the equator
  append_arc(profile, 0, half_straight, radius, 0, kPi / 2, steps);
  return lathe(profile, segments);
}

Mesh box_mesh(Vec3 half, float bevel) {
  const std::array<float, 3> halves = {half.x, half.y, half.z};
  Mesh mesh;
  for (int normal = 0; normal < 3; ++normal) {
    int u = (normal + 1) % 3, v = (normal + 2) % 3;
    // Wood grain runs along u, the longer side.
    if (halves[static_cast<size_t>(v)] > halves[static_cast<size_t>(u)]) std::swap(u, v);
    append_face(mesh, half, bevel, u, v, 1);
    append_face(mesh, half, bevel, u, v, -1);
  }
  return mesh;
}

Mesh link_mesh(float half_length, float radius_near, float radius_far, float half_depth, float bevel) {
  // Outline of two circles with their common tangents in the XZ plane, counter-clockwise as seen from -Y.
  const float lean = std::asin((radius_near - radius_far) / (2 * half_length));
  const int steps = 20;
  Profile outline;  // radius stands for x and height for z
  append_arc(outline, 0, 0, 1, -kPi / 2 + lean, kPi / 2 - lean, steps);
  append_arc(outline, 0, 0, 1, kPi / 2 - lean, 3 * kPi / 2 + lean, steps);
  Mesh mesh;
  const auto count = static_cast<int>(outline.size());
  auto point = [&](int i, float inset) -> Vec3 {
    const ProfilePoint& p = outline[static_cast<size_t>(i % count)];
    const bool far = i % count <= steps;
    const float radius = (far ? radius_far : radius_near) - inset;
    return {(far ? half_length : -half_length) + radius * p.normal_radius, 0, radius * p.normal_height};
  };
  // Rings from -Y to +Y; on bevels the normal turns from the side to the cap.
  Profile rings;
  append_arc(rings, -bevel, -half_depth + bevel, bevel, -kPi / 2, 0, kBevelSteps);
  append_arc(rings, -bevel, half_depth - bevel, bevel, 0, kPi / 2, kBevelSteps);
  for (const ProfilePoint& ring_shape : rings) {
    const float sideways = ring_shape.normal_radius, y = ring_shape.height;
    const float inset = bevel * (1 - sideways);
    float along = 0;
    for (int i = count; i >= 0; --i) {  // reversed, so that faces point outwards
      const ProfilePoint& p = outline[static_cast<size_t>(i % count)];
      const Vec3 at = point(i, inset);
      if (i < count) {
        const Vec3 step = at - point(i + 1, inset);
        along += std::sqrt(dot(step, step));
      }
      const Vec3 normal = {p.normal_radius * sideways, ring_shape.normal_height, p.normal_height * sideways};
      mesh.vertices.push_back({{at.x, y, at.z}, normal, {p.normal_height, 0, -p.normal_radius}, 1, along, y});
    }
  }
  append_grid(mesh, 0, count, static_cast<int>(rings.size()) - 1);
  for (float side : {-1.0f, 1.0f}) {
    // Same coordinates as the outermost ring, for a watertight edge.
    const ProfilePoint& ring_shape = side < 0 ? rings.front() : rings.back();
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    const Vec3 tangent = {-side, 0, 0};
    mesh.vertices.push_back({{0, ring_shape.height, 0}, {0, side, 0}, tangent, 1, 0, 0});
    for (int i = 0; i <= count; ++i) {
      const Vec3 at = point(i, bevel * (1 - ring_shape.normal_radius));
      mesh.vertices.push_back(
          {{at.x, ring_shape.height, at.z}, {0, side, 0}, tangent, 1, -side * at.x, at.z});
    }
    for (uint32_t i = 0; i < static_cast<uint32_t>(count); ++i) {
      const uint32_t a = first + 1 + i, b = a + 1;
      for (uint32_t index : {first, side < 0 ? a : b, side < 0 ? b : a}) mesh.indices.push_back(index);
    }
  }
  return mesh;
}

Mesh floor_mesh(float half_extent) {
  Mesh mesh;
  for (float y : {-half_extent, half_extent}) {
    for (float x : {-half_extent, half_extent})
      mesh.vertices.push_back({{x, y, 0}, {0, 0, 1}, {1, 0, 0}, 1, x, y});
  }
  append_grid(mesh, 0, 1, 1);
  return mesh;
}

Mesh backdrop_mesh(float radius, float height, float bend) {
  // From the top to the floor, so that faces point inwards.
  Profile profile{{radius, height, -1, 0}};
  for (int i = 0; i <= 12; ++i) {
    const float angle = kPi / 2 * static_cast<float>(i) / 12;
    const float c = std::cos(angle), s = std::sin(angle);
    profile.push_back({radius - bend + bend * c, bend - bend * s, -c, s});
  }
  constexpr float kOver = 0.6f;  // beyond a half turn, so that the ends stay outside the camera views
  return lathe(profile, 80, -kOver, kPi + 2 * kOver);
}

Mesh moved(Mesh mesh, Vec3 by) {
  for (Vertex& vertex : mesh.vertices) vertex.position = vertex.position + by;
  return mesh;
}

Mesh z_to_x(Mesh mesh) {
  const auto turn = [](Vec3 a) { return Vec3{a.z, a.x, a.y}; };
  for (Vertex& v : mesh.vertices)
    v.position = turn(v.position), v.normal = turn(v.normal), v.tangent = turn(v.tangent);
  return mesh;
}

Mesh z_to_y(Mesh mesh) {
  const auto turn = [](Vec3 a) { return Vec3{a.y, a.z, a.x}; };
  for (Vertex& v : mesh.vertices)
    v.position = turn(v.position), v.normal = turn(v.normal), v.tangent = turn(v.tangent);
  return mesh;
}

}  // namespace examples
