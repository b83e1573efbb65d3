// Accessors to vertex attributes of a scene, for tests.
#pragma once

#include <vector>

#include "renderer/scene/model/vertices.h"

namespace fire3dv::test {

inline std::vector<scene::VertexAttributes> attributes_of(const scene::Scene& scene) {
  std::vector<scene::VertexAttributes> attributes;
  for (uint32_t v = 0; v < scene.positions.size(); ++v) attributes.push_back(scene::attributes_of(scene, v));
  return attributes;
}

inline void set_attributes(scene::Scene& scene, const std::vector<scene::VertexAttributes>& attributes) {
  scene.frames.clear();
  scene.tangents.clear();
  scene.uvs.clear();
  scene.extras.clear();
  scene::append_attributes(scene, attributes);
}

}  // namespace fire3dv::test
