// Skins and morph targets, on the GPU: writes the vertices of deformed meshes whenever something has moved,
// the spheres around them, and lets their acceleration structures follow.
#pragma once

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipeline.h"
#include "renderer/passes/gpu_scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

class DeformPass {
 public:
  DeformPass(gpu::Device& device, VkPipelineLayout layout);

  // After the transforms.
  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, GpuScene& scene, const state::PoseState& poses);
  // Before the top level, where rays are traced.
  void record_levels(gpu::Recorder& recorder, GpuScene& scene);
  // The scene was replaced.
  void forget() {
    poses_seen_ = weights_seen_ = UINT64_MAX;
    levels_behind_ = true;
  }
  // Others have written vertices.
  void vertices_written() { levels_behind_ = true; }

 private:
  void upload_weights(gpu::Recorder& recorder, gpu::UploadBelt& belt, DeformedShapes& shapes,
                      const state::PoseState& poses);

  VkPipelineLayout layout_;
  gpu::Pipeline deform_, bounds_;
  uint64_t poses_seen_ = UINT64_MAX, weights_seen_ = UINT64_MAX;  // PoseState's revisions
  bool levels_behind_ = true;  // vertices were written since acceleration structures last followed
};

}  // namespace fire3dv::passes
