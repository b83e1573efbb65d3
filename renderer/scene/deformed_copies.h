// Nodes whose mesh changes its shape have its vertices to themselves: copies behind those of the scene, which
// a pass writes anew whenever something moves. Triangles are shared.
#pragma once

#include <cstdint>
#include <vector>

#include "protocol/error.h"
#include "renderer/scene/clusters.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// By a skin, by morph targets, or by vertices that are replaced.
bool is_deformed(const Node& node);

// Whether the joints of a skinned node turn its triangles inside out, at rest: its own transform has no part
// in that.
bool is_mirrored_by_joints(const Scene& scene, const Node& node);

// Vertices of a mesh's copy, at most, and of the copies of all nodes that are deformed.
uint64_t corners_of_mesh(const Scene& scene, const Mesh& mesh);
uint64_t deformed_corners(const Scene& scene);
// Some 5 GB on the GPU, were no vertex shared between triangles.
constexpr uint64_t kMaxDeformedCorners = uint64_t{1} << 26;

// Thousands of nodes may share a mesh, each with a copy of it: refuses what no machine has the memory for.
Result<void> check_deformed_copies(const Scene& scene);

struct DeformedNode {
  uint32_t node = 0;
  uint32_t first_primitive = 0;  // into ClusteredGeometry::primitives: copies of all primitives of the mesh
};

// Appends the copies, in node order.
std::vector<DeformedNode> add_deformed_copies(const Scene& scene, ClusteredGeometry& geometry);

}  // namespace fire3dv::scene
