// Accessors to nodes, meshes and bounds of a model, for tests of readers.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <utility>

#include "convert/model.h"

namespace fire3dv::convert {

inline const Node& node(const Model& model, std::string_view name) {
  for (const Node& each : model.nodes)
    if (each.name == name) return each;
  ADD_FAILURE() << "no node " << name;
  return model.nodes.front();
}

inline std::pair<glm::vec3, glm::vec3> bounds(const Mesh& mesh) {
  glm::vec3 low(1e9f), high(-1e9f);
  for (const Surface& surface : mesh.surfaces) {
    for (const glm::vec3& position : surface.positions) {
      low = glm::min(low, position);
      high = glm::max(high, position);
    }
  }
  return {low, high};
}

}  // namespace fire3dv::convert
