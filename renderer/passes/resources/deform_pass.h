// Skinning and morph targets on the GPU: after each change, updates deformed vertices, bounding spheres and
// acceleration structures.
#pragma once

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

class DeformPass {
 public:
  DeformPass(gpu::Device& device, VkPipelineLayout layout);

  // Call it after the transforms pass.
  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
              const state::PoseState& poses);
  // Updates the bottom-level structures. Call it before the top-level build, where rays are traced.
  void record_levels(gpu::Recorder& recorder, GpuScene& scene);
  // Resets the state for a new scene.
  void invalidate() {
    poses_revision_ = weights_revision_ = UINT64_MAX;
    levels_outdated_ = true;
  }
  // Reports vertices written by another pass.
  void invalidate_vertices() { levels_outdated_ = true; }

 private:
  void upload_weights(gpu::Recorder& recorder, gpu::StagingRing& staging, DeformedShapes& shapes,
                      const state::PoseState& poses);

  VkPipelineLayout layout_;
  gpu::Pipeline deform_, bounds_;
  uint64_t poses_revision_ = UINT64_MAX, weights_revision_ = UINT64_MAX;  // PoseState's revisions
  bool levels_outdated_ = true;  // vertices changed since the last structure update
};

}  // namespace fire3dv::passes
