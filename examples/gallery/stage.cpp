#include "examples/gallery/stage.h"

#include <cmath>
#include <span>

namespace gallery {

using examples::GltfLight;
using examples::GltfMaterial;
using examples::GltfMatrix;
using examples::GltfWriter;
using examples::Mesh;
using examples::Vec3;

namespace {

// Pose of a camera or light at `eye` that looks along its -Z.
GltfMatrix looking(Vec3 eye, Vec3 target) {
  const Vec3 back = normalized(eye - target);
  const Vec3 right = normalized(cross({0, 1, 0}, back));
  const Vec3 up = cross(back, right);
  return {right.x, up.x, back.x, eye.x, right.y, up.y, back.y, eye.y, right.z, up.z, back.z, eye.z};
}

}  // namespace

GltfMatrix standing(Vec3 at, float turn_rad) {
  const float c = std::cos(turn_rad), s = std::sin(turn_rad);
  return {c, -s, 0, at.x, 0, 0, 1, at.y, -s, -c, 0, at.z};
}

GltfMatrix facing(Vec3 at, Vec3 normal) {
  const Vec3 u = normalized(cross(std::abs(normal.y) < 0.9f ? Vec3{0, 1, 0} : Vec3{0, 0, 1}, normal));
  const Vec3 v = cross(normal, u);
  return {u.x, v.x, normal.x, at.x, u.y, v.y, normal.y, at.y, u.z, v.z, normal.z, at.z};
}

Mesh ball(float radius) {
  return examples::capsule_mesh(radius, 0, 96);
}

void Stage::shape(const std::string& name, const Mesh& mesh, const GltfMaterial& material,
                  const GltfMatrix& pose) {
  const GltfWriter::Primitive primitive{&mesh, writer_.add_material(material), 1};
  GltfWriter::Node node{name, pose, {}, {}, {}};
  node.mesh = writer_.add_mesh(name, std::span(&primitive, 1));
  writer_.add_node(node);
}

void Stage::light(const GltfLight& light, Vec3 eye, Vec3 target) {
  GltfWriter::Node node{light.name, looking(eye, target), {}, {}, {}};
  node.light = writer_.add_light(light);
  writer_.add_node(node);
}

void Stage::camera(const std::string& name, Vec3 eye, Vec3 target, float vertical_fov_rad) {
  GltfWriter::Node node{name, looking(eye, target), {}, {}, {}};
  node.camera = writer_.add_camera(name, vertical_fov_rad, 0.05f);
  writer_.add_node(node);
}

void Stage::ground(std::array<float, 3> color) {
  shape("ground", examples::floor_mesh(30), {"ground", color, 0, 0.9f, {}, {}, {}, {}}, standing({}));
}

SceneFile Stage::finish(const std::string& name) const {
  return {name + ".glb", writer_.finish(name, "FIRE-3DV gallery")};
}

}  // namespace gallery
