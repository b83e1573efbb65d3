// Triangle meshes and scenes without files, for tests of geometry.
#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <random>
#include <vector>

#include "renderer/scene/model/scene.h"
#include "renderer/scene/model/vertices.h"

namespace fire3dv::test {

struct Triangles {
  std::vector<glm::vec3> positions;
  std::vector<uint32_t> indices;

  void add(const Triangles& other, const glm::vec3& offset = glm::vec3(0)) {
    const auto first = static_cast<uint32_t>(positions.size());
    for (const glm::vec3& p : other.positions) positions.push_back(p + offset);
    for (uint32_t index : other.indices) indices.push_back(first + index);
  }
  void turn_inside_out() {
    for (size_t i = 0; i < indices.size(); i += 3) std::swap(indices[i + 1], indices[i + 2]);
  }
};

// Four vertices per side, as in files with flat normals.
inline Triangles box_triangles(glm::vec3 half) {
  Triangles box;
  for (int axis = 0; axis < 3; ++axis) {
    for (float side : {-1.0f, 1.0f}) {
      glm::vec3 n(0), u(0);
      n[axis] = side;
      u[(axis + 1) % 3] = 1;
      const glm::vec3 v = glm::cross(n, u);
      Triangles face;
      for (const glm::vec2 corner :
           {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
        face.positions.push_back((n + u * corner.x + v * corner.y) * half);
      }
      face.indices = {0, 1, 2, 0, 2, 3};
      box.add(face);
    }
  }
  return box;
}

// Vertices are shared: closed without welding. `bump` displaces them radially.
inline Triangles ball_triangles(float radius, uint32_t segments, float bump = 0) {
  const uint32_t rings = segments / 2;
  Triangles ball;
  auto place = [&](float theta, float phi) {
    const float r = radius * (1 + bump * std::sin(5 * theta) * std::sin(7 * phi));
    return r * glm::vec3(std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi));
  };
  for (uint32_t r = 1; r < rings; ++r) {
    for (uint32_t s = 0; s < segments; ++s) {
      ball.positions.push_back(place(static_cast<float>(r) / static_cast<float>(rings) * 3.14159265f,
                                     static_cast<float>(s) / static_cast<float>(segments) * 6.28318531f));
    }
  }
  const auto north = static_cast<uint32_t>(ball.positions.size());
  ball.positions.push_back({0, radius, 0});
  ball.positions.push_back({0, -radius, 0});
  for (uint32_t s = 0; s < segments; ++s) {
    const uint32_t next = (s + 1) % segments, last = (rings - 2) * segments;
    for (uint32_t i : {north, s, next, north + 1, last + next, last + s}) ball.indices.push_back(i);
    for (uint32_t r = 0; r + 2 < rings; ++r) {
      const uint32_t a = r * segments + s, b = r * segments + next, c = a + segments, d = b + segments;
      for (uint32_t i : {a, c, b, b, c, d}) ball.indices.push_back(i);
    }
  }
  return ball;
}

// Random triangles without shared vertices.
inline Triangles soup_triangles(uint32_t corners) {
  Triangles soup;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(-1, 1);
  for (uint32_t i = 0; i < corners; ++i) {
    soup.positions.emplace_back(place(random), place(random), place(random));
    soup.indices.push_back(i);
  }
  return soup;
}

inline void add_primitive(scene::Scene& scene, const Triangles& triangles, uint32_t material = 0,
                          scene::Topology topology = scene::Topology::triangles) {
  if (scene.materials.empty()) scene.materials.emplace_back();
  scene::Primitive primitive;
  primitive.topology = topology;
  primitive.first_index = static_cast<uint32_t>(scene.indices.size());
  primitive.index_count = static_cast<uint32_t>(triangles.indices.size());
  primitive.first_vertex = static_cast<uint32_t>(scene.positions.size());
  primitive.vertex_count = static_cast<uint32_t>(triangles.positions.size());
  primitive.material = material;
  scene.positions.insert(scene.positions.end(), triangles.positions.begin(), triangles.positions.end());
  scene::append_attributes(scene, std::vector<scene::VertexAttributes>(triangles.positions.size()));
  scene.indices.insert(scene.indices.end(), triangles.indices.begin(), triangles.indices.end());
  scene.primitives.push_back(primitive);
}

// Adds a mesh of all primitives that have none yet.
inline void add_mesh(scene::Scene& scene) {
  const uint32_t first =
      scene.meshes.empty() ? 0 : scene.meshes.back().first_primitive + scene.meshes.back().primitive_count;
  scene.meshes.push_back({"", first, static_cast<uint32_t>(scene.primitives.size()) - first});
}

}  // namespace fire3dv::test
