#include "renderer/scene/scene.h"

namespace fire3dv::scene {

std::vector<uint32_t> camera_nodes(const Scene& scene) {
  std::vector<uint32_t> nodes;
  for (uint32_t index = 0; index < scene.nodes.size(); ++index) {
    if (scene.nodes[index].camera != kNone) nodes.push_back(index);
  }
  return nodes;
}

}  // namespace fire3dv::scene
