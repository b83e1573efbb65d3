// Estimate of a scene's device memory, computed from its arrays before any upload. Peers are charged for
// their additions by it, and it is compared with the available memory.
#pragma once

#include <cstdint>

#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::app {

// Bytes of a whole scene: textures with mip levels, vertices, indices, clusters, acceleration structures, and
// copies of deformed nodes. An upper bound: it assumes that rays are traced to triangles.
uint64_t estimate_gpu_bytes(const scene::Scene& scene, const scene::Derived& derived);

// Additional bytes of a node whose vertices are replaced: per-instance vertices, clusters and acceleration
// structure.
uint64_t estimate_deformed_bytes(const scene::Scene& scene, const scene::Derived& derived, uint32_t node);

}  // namespace fire3dv::app
