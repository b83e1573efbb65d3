// EXT_mesh_gpu_instancing loader: instance transforms of a node's mesh. It limits the instances per file.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Reads instance transforms and counts instances over the whole file.
class Instancing {
 public:
  Instancing(const GltfDocument& document, const LoadLimits& limits) : document_(document), limits_(limits) {}

  // Transform from each instance to the node's frame; nullopt if the node has no such extension.
  Result<std::optional<std::vector<glm::mat4>>> node_from_instances(const tinygltf::Node& source,
                                                                    const std::string& where);

 private:
  const GltfDocument& document_;
  const LoadLimits& limits_;
  size_t instances_ = 0;
};

}  // namespace fire3dv::scene
