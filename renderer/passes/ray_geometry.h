// What of a scene rays meet, as triangles or as boxes of them, and who needs triangles' indices for that or
// for drawing.
#pragma once

#include <vector>

#include "renderer/passes/gpu_scene.h"

namespace fire3dv::passes {

// False where all is drawn by clusters, nothing is deformed and rays meet boxes alone.
bool needs_indices(const scene::Scene& scene, const scene::ClusteredGeometry& clustered,
                   const SceneUses& uses, bool traces_rays);

// Of each mesh, from its positions, indices and boxes; none of a mesh that only deformed nodes show.
std::vector<std::vector<gpu::TriangleGeometry>> static_geometry(const scene::Scene& scene,
                                                                const GpuScene& gpu_scene);
// Of each deformed node.
std::vector<std::vector<gpu::TriangleGeometry>> deformed_geometry(const scene::Scene& scene,
                                                                  const GpuScene& gpu_scene);

}  // namespace fire3dv::passes
