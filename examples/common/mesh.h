// Triangle meshes of smooth, bevelled shapes for the scene files, and coordinate frames. Bevels catch
// highlights. Body frames: Z up, metres. Texture coordinates are in metres too, so that a material has one
// scale everywhere.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace examples {

struct Vec3 {
  float x = 0, y = 0, z = 0;
};
inline Vec3 operator+(Vec3 a, Vec3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(Vec3 a, Vec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(Vec3 a, float s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline float dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec3 normalized(Vec3 a) {
  return a * (1.0f / std::sqrt(dot(a, a)));
}

struct Vertex {
  Vec3 position;
  Vec3 normal;
  Vec3 tangent;          // direction of increasing u
  float handedness = 1;  // bitangent = cross(normal, tangent) * handedness
  float u = 0, v = 0;
};

struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<uint32_t> indices;
};

// Mesh with a material name; a body is a list of parts.
struct Part {
  Mesh mesh;
  std::string material;
};

// Solids about Z. bevel > 0; a capsule without straight part is a sphere.
Mesh cylinder_mesh(float radius, float half_height, float bevel, int segments = 48);
Mesh capsule_mesh(float radius, float half_straight, int segments = 32);
Mesh box_mesh(Vec3 half, float bevel);
// Link with rounded ends of two radii about the Y axes at x = -half_length and x = +half_length; thickness 2
// half_depth.
Mesh link_mesh(float half_length, float radius_near, float radius_far, float half_depth, float bevel);
// Flat, in XY, facing +Z.
Mesh floor_mesh(float half_extent);
// Curved backdrop: floor that bends up into a wall, about Z from +X over +Y to -X and slightly beyond, facing
// inwards.
Mesh backdrop_mesh(float radius, float height, float bend);

Mesh moved(Mesh mesh, Vec3 by);
Mesh z_to_x(Mesh mesh);  // rotates the Z axis to X
Mesh z_to_y(Mesh mesh);

// Coordinate frames of the examples. The stream frame is the simulator's: Z up. The renderer's world and the
// node meshes follow glTF: Y up. A node's pose is world_from_stream * stream_from_body * body_from_node. Both
// constants are rotations by 90 degrees without rounding, so that stream poses and rest poses agree bit by
// bit. 3x4, row-major.
constexpr std::array<double, 12> kWorldFromStream = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};
constexpr std::array<float, 12> kBodyFromNode = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0};

// Z up to Y up; serves as world_from_stream and node_from_body.
inline Vec3 y_up(Vec3 a) {
  return {a.x, a.z, -a.y};
}

inline Mesh y_up(Mesh mesh) {
  for (Vertex& v : mesh.vertices)
    v.position = y_up(v.position), v.normal = y_up(v.normal), v.tangent = y_up(v.tangent);
  return mesh;
}

}  // namespace examples
