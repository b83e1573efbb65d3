// Triangle meshes of smooth, bevelled shapes for the scene files; bevels catch highlights. Body frames: Z up,
// metres. Texture coordinates are in metres too, so that a material has one scale everywhere.
#pragma once

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

}  // namespace examples
