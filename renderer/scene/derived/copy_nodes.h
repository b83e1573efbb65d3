// Copies of nodes within a scene. A copy shares meshes, lights and cameras with its source.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"
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

// Nodes to copy, and the growth of the scene by their copies.
struct CopyPlan {
  std::vector<uint32_t> sources;  // a node and its descendants, in scene order
  // Skins whose joints are all among the sources, ascending: those of the copies follow the copies.
  std::vector<uint32_t> own_skins;
  uint64_t joints = 0, morph_weights = 0;
  uint64_t deformed_corners = 0;  // see clusters.h
  uint64_t host_bytes = 0;        // without paths
};
CopyPlan plan_copy(const Scene& scene, std::vector<uint32_t> sources);

// Bytes of the paths of the copies, if that of the first one is `path`. Instances have no path.
uint64_t path_bytes_of_copy(const Scene& scene, const std::vector<uint32_t>& sources,
                            const std::string& path);

// Gives `copy`, the last node of the scene, the contents of the first source, and appends copies of the
// others below it, in this order. Like nodes of an added asset they are found by their paths alone.
// Animations stay with the sources. deformed_corners: of the scene, whose growth is added. The error names
// the limit that the scene would exceed; it has not changed then.
Result<void> copy_below(Scene& scene, const CopyPlan& plan, uint32_t copy, uint64_t& deformed_corners);

}  // namespace fire3dv::scene
