// World transforms of all nodes, computed on the GPU from raw stream poses. The CPU uploads only streams with
// a new frame, and the drive table after binding changes.
#pragma once

#include <vector>

#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

class TransformsPass {
 public:
  TransformsPass(gpu::Device& device, VkPipelineLayout layout);

  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
              const state::PoseState& poses);
  // Resets the state for a new scene; all data is uploaded again.
  void invalidate();

 private:
  struct StreamPoses {
    gpu::Buffer poses;
    uint64_t epoch = 0, revision = UINT64_MAX;
  };
  void upload_drives(gpu::Recorder& recorder, gpu::StagingRing& staging, const state::PoseState& poses);
  void upload_poses(gpu::Recorder& recorder, gpu::StagingRing& staging, const state::PoseState& poses);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  gpu::Pipeline pipeline_;
  gpu::Buffer sources_;
  uint64_t uploaded_drives_ = UINT64_MAX;
  std::vector<StreamPoses> streams_;
};

}  // namespace fire3dv::passes
