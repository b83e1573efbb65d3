// Estimate of the device memory that a scene takes, made from its arrays before anything is uploaded. Charged
// to peers for what they add, and compared with the memory that the device has left.
#pragma once

#include <cstdint>

#include "renderer/scene/derived.h"
#include "renderer/scene/scene.h"

namespace fire3dv::passes {

// All of a scene: textures with their mip levels, vertices, indices, clusters, acceleration structures, and
// the copies of deformed nodes. An upper estimate: it assumes that rays are traced to triangles.
uint64_t estimate_gpu_bytes(const scene::Scene& scene, const scene::Derived& derived);

// What a node takes in addition once its vertices are replaced: its own vertices, clusters and acceleration
// structure.
uint64_t estimate_deformed_bytes(const scene::Scene& scene, const scene::Derived& derived, uint32_t node);

}  // namespace fire3dv::passes
