// The GPU's copy of a Scene: derived, never edited. Geometry, materials and textures are uploaded once; what moves is
// written by the transforms pass.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/gpu/acceleration.h"
#include "renderer/gpu/bindless_textures.h"
#include "renderer/gpu/resources.h"
#include "renderer/passes/draw_list.h"
#include "renderer/scene/scene.h"

namespace fire3dv::passes {

struct GpuScene {
  GpuScene(gpu::Device& device, const scene::Scene& scene);

  uint32_t node_count = 0;
  uint32_t light_count = 0;
  uint32_t instance_count = 0;  // of the top-level acceleration structure

  gpu::Buffer positions, vertices, indices;
  gpu::Buffer materials, primitives, lights;
  gpu::Buffer draws;                    // DrawRecord[], in the order of the draw list
  gpu::Buffer first_primitive_of_node;  // uint[]
  gpu::Buffer instance_of_node;         // uint[]
  gpu::Buffer instances;                // VkAccelerationStructureInstanceKHR[]
  gpu::Buffer world_from_node;          // AffineRows[], written by the transforms pass

  DrawList draw_list;
  std::vector<gpu::Image> images;
  std::vector<gpu::Sampler> samplers;
  std::vector<gpu::AccelerationStructure> blas_of_mesh;
  gpu::TopLevel top_level;              // only with ray queries
  gpu::BindlessTextures textures;
  gpu::BlasBuildReport blas_report;
};

}  // namespace fire3dv::passes
