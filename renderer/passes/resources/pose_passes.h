// Passes that bring poses to the GPU scene: node transforms, then skinning and morph targets with their data.
#pragma once

#include <span>
#include <vector>

#include "renderer/gpu/acceleration.h"
#include "renderer/gpu/frame_ring.h"
#include "renderer/gpu/loader_commands.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/scene/clusters/clusters.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

struct GpuScene;

// Poses of each world.
using PosesOfWorlds = std::span<const state::PoseState* const>;

// World transforms of all nodes in all worlds, computed on the GPU from raw stream poses. The CPU uploads
// only streams with a new frame, and the drive table after binding changes.
class TransformsPass {
 public:
  TransformsPass(gpu::Device& device, VkPipelineLayout layout);

  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene, PosesOfWorlds poses);
  // Starts compilation of the pipeline of several worlds, if missing.
  void expect_worlds();
  // Resets the state for a new scene; all data is uploaded again.
  void invalidate() {
    worlds_.clear();
    source_bytes_ = 0;
  }

 private:
  struct StreamPoses {
    VkDeviceSize offset = 0;  // in poses_
    size_t capacity = 0;      // poses; 0: no room yet
    uint64_t epoch = 0, revision = UINT64_MAX;
  };
  // Uploaded data of a world.
  struct World {
    uint64_t drives = UINT64_MAX;  // PoseState::drive_revision()
    std::vector<StreamPoses> streams;
  };
  void upload_drives(gpu::Recorder& recorder, gpu::StagingRing& staging, PosesOfWorlds poses);
  void make_room_for_poses(PosesOfWorlds poses);
  void upload_poses(gpu::Recorder& recorder, gpu::StagingRing& staging, PosesOfWorlds poses);

  gpu::Device& device_;
  VkPipelineLayout layout_;
  gpu::Pipeline pipelines_[2];  // of one world; of several in one dispatch
  // Of all worlds, so that one copy can upload what has changed in them.
  gpu::Buffer sources_, poses_;
  VkDeviceSize source_bytes_ = 0;  // stride of the worlds in sources_
  std::vector<World> worlds_;
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
  uint32_t record_count = 0, group_count = 0;
};

// Deformation of a world.
struct DeformedWorld {
  gpu::Buffer weights;         // float[], uploaded by the deform pass
  gpu::DeformedLevels levels;  // one per node of DeformedShapes, where rays can be traced
};

// Skinning and morph targets on the GPU: after each change, updates deformed vertices, bounding spheres and
// acceleration structures.
class DeformPass {
 public:
  DeformPass(gpu::Device& device, VkPipelineLayout layout);

  // Call it after the transforms pass.
  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene, PosesOfWorlds poses);
  // Updates the bottom-level structures. Call it before the top-level build, where rays are traced.
  void record_levels(gpu::Recorder& recorder, GpuScene& scene);
  // Resets the state for a new scene.
  void invalidate() {
    worlds_.clear();
    levels_outdated_ = true;
  }
  // Reports vertices written by another pass.
  void invalidate_vertices() { levels_outdated_ = true; }

 private:
  // PoseState's revisions that a world was deformed for.
  struct World {
    uint64_t poses = UINT64_MAX, weights = UINT64_MAX;
  };
  void upload_weights(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
                      PosesOfWorlds poses);

  VkPipelineLayout layout_;
  gpu::Pipeline deform_, bounds_;
  std::vector<World> worlds_;
  bool levels_outdated_ = true;  // vertices changed since the last structure update
};

}  // namespace fire3dv::passes
