// Poses as they came over the wire to world transforms of all nodes, on the GPU. The CPU touches only streams
// whose shown frame changed, and the table of drives when bindings changed.
#pragma once

#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipeline.h"
#include "renderer/passes/gpu_scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

class TransformsPass {
 public:
  TransformsPass(gpu::Device& device, VkPipelineLayout layout);

  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, GpuScene& scene, const state::PoseState& poses);
  // The scene was replaced: all is uploaded anew.
  void forget();

 private:
  struct StreamPoses {
    gpu::Buffer poses;
    uint64_t epoch = 0, revision = UINT64_MAX;
  };
  void upload_drives(gpu::Recorder& recorder, gpu::UploadBelt& belt, const state::PoseState& poses);
  void upload_poses(gpu::Recorder& recorder, gpu::UploadBelt& belt, const state::PoseState& poses);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Buffer sources_;
  uint64_t uploaded_drives_ = UINT64_MAX;
  std::vector<StreamPoses> streams_;
};

}  // namespace fire3dv::passes
