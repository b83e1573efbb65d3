// Per-instance vertices of deformed nodes (skins, morph targets, replaced vertices). The copies follow the
// scene's vertices; the deform pass rewrites them when a pose changes. Triangles are shared.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// True if a skin, morph targets or replaced vertices deform the node.
bool is_deformed(const Node& node);

// True if the joints of a skinned node invert the winding at rest. The node's own transform has no influence.
bool is_mirrored_by_joints(const Scene& scene, const Node& node);

// Upper bound on vertices of a mesh's copy, and of the copies of all deformed nodes.
uint64_t corners_of_mesh(const Scene& scene, const Mesh& mesh);
uint64_t deformed_corners(const Scene& scene);
// About 5 GB of GPU memory if triangles share no vertices.
constexpr uint64_t kMaxDeformedCorners = uint64_t{1} << 26;

// Thousands of nodes may share a deformed mesh; fails above kMaxDeformedCorners.
Result<void> check_deformed_copies(const Scene& scene);

struct DeformedNode {
  uint32_t node = 0;
  uint32_t first_primitive = 0;  // first copied primitive in ClusteredGeometry::primitives
};

// Appends copies in node order.
std::vector<DeformedNode> add_deformed_copies(const Scene& scene, ClusteredGeometry& geometry);

}  // namespace fire3dv::scene
