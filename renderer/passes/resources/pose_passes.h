// Passes that bring poses to the GPU scene: node transforms, then skinning and morph targets with their data.
#pragma once

#include <vector>

#include "renderer/gpu/acceleration.h"
#include "renderer/gpu/device/loader_commands.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/scene/clusters/clusters.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

struct GpuScene;

// World transforms of all nodes, computed on the GPU from raw stream poses. The CPU uploads only streams with
// a new frame, and the drive table after binding changes.
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

// Deformation data of a scene on the GPU: joints, influences, morph deltas and refittable acceleration
// structures. Uploaded once; the deform pass reads it.
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

// Skinning and morph targets on the GPU: after each change, updates deformed vertices, bounding spheres and
// acceleration structures.
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
