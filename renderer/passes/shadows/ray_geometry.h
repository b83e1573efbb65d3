// Geometry of the bottom-level acceleration structures, as triangles or boxes, and the need for index
// buffers.
#pragma once

#include <vector>

#include "renderer/passes/resources/gpu_scene.h"

namespace fire3dv::passes {

// False where all draws use clusters, no mesh is deformed and rays are traced to boxes only.
bool needs_indices(const scene::Scene& scene, const scene::ClusteredGeometry& clustered,
                   const SceneUses& uses, bool traces_rays);

// Geometries of each mesh, from its positions, indices and boxes; empty for a mesh that only deformed nodes
// use.
std::vector<std::vector<gpu::TriangleGeometry>> static_geometry(const scene::Scene& scene,
                                                                const GpuScene& gpu_scene);
// Geometries of each deformed node.
std::vector<std::vector<gpu::TriangleGeometry>> deformed_geometry(const scene::Scene& scene,
                                                                  const GpuScene& gpu_scene);

}  // namespace fire3dv::passes
