// Deformation data of a scene on the GPU: joints, influences, morph deltas and refittable acceleration
// structures. Uploaded once; the deform pass reads it.
#pragma once

#include <vector>

#include "renderer/gpu/deformed_levels.h"
#include "renderer/gpu/device/loader_commands.h"
#include "renderer/scene/edits/deformed_vertices.h"

namespace fire3dv::passes {

struct DeformedShapes {
  DeformedShapes() = default;
  // nodes, geometry: from scene::add_deformed_copies().
  DeformedShapes(gpu::Device& device, gpu::LoaderCommands& loader, const scene::Scene& scene,
                 std::vector<scene::DeformedNode> nodes, const scene::ClusteredGeometry& geometry);

  std::vector<scene::DeformedNode> nodes;
  gpu::Buffer records, groups, sources;  // see gpu_types::DeformRecord
  gpu::Buffer influences, joints, joint_bounds, deltas;
  gpu::Buffer weights;  // float[], written by the deform pass
  uint32_t record_count = 0, group_count = 0;
  gpu::DeformedLevels levels;  // one per node of `nodes`, where rays can be traced
};

}  // namespace fire3dv::passes
