// Copies of nodes within a scene. A copy shares meshes, lights and cameras with its source.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Descendants of nodes of a growing scene. Each node is indexed once.
class Descendants {
 public:
  // The node and its descendants in scene order, so that parents come first. is_left_out: a node that is left
  // out with all below it.
  std::vector<uint32_t> of(const Scene& scene, uint32_t top,
                           const std::function<bool(uint32_t)>& is_left_out);

 private:
  std::vector<uint32_t> first_child_, next_sibling_;
};

// Gives `copy`, the last node of the scene, the contents of the first of these nodes, and appends copies of
// the others below it, in this order. Like nodes of an added asset they are found by their paths alone. Skins
// whose joints are all among the nodes follow the copies. Animations stay with the sources.
Result<void> copy_below(Scene& scene, const std::vector<uint32_t>& sources, uint32_t copy);

}  // namespace fire3dv::scene
