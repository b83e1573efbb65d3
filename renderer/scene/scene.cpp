#include "renderer/scene/scene.h"

namespace fire3dv::scene {

AlphaMode drawn_alpha_mode(const Material& material) {
  return material.transmission > 0 && !material.unlit ? AlphaMode::blend : material.alpha_mode;
}

std::vector<uint32_t> camera_nodes(const Scene& scene) {
  std::vector<uint32_t> nodes;
  for (uint32_t index = 0; index < scene.nodes.size(); ++index) {
    if (scene.nodes[index].camera != kNone) nodes.push_back(index);
  }
  return nodes;
}

}  // namespace fire3dv::scene
