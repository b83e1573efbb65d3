// EXT_mesh_gpu_instancing: a node that draws its mesh many times.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/gltf_document.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// Reads the instances of nodes, and counts them over the whole file.
class Instancing {
 public:
  Instancing(const GltfDocument& document, const LoadLimits& limits) : document_(document), limits_(limits) {}

  // Of each instance the transform to the node's frame; nothing where the node has no such extension.
  Result<std::optional<std::vector<glm::mat4>>> node_from_instances(const tinygltf::Node& source,
                                                                    const std::string& where);

 private:
  const GltfDocument& document_;
  const LoadLimits& limits_;
  size_t instances_ = 0;
};

}  // namespace fire3dv::scene
