#include "renderer/passes/resources/deform_pass.h"

#include <algorithm>

#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

// Rows of 65535 groups, the guaranteed minimum of all devices.
void dispatch(VkCommandBuffer commands, uint32_t groups) {
  if (groups) vkCmdDispatch(commands, std::min(groups, 65535u), (groups + 65534) / 65535, 1);
}

}  // namespace

DeformPass::DeformPass(gpu::Device& device, VkPipelineLayout layout)
    : layout_(layout),
      deform_(gpu::create_compute_pipeline(device, layout, "deform.comp", gpu::Compile::on_first_use)),
      bounds_(
          gpu::create_compute_pipeline(device, layout, "deform_bounds.comp", gpu::Compile::on_first_use)) {}

void DeformPass::upload_weights(gpu::Recorder& recorder, gpu::StagingRing& staging, DeformedShapes& shapes,
                                const state::PoseState& poses) {
  if (weights_revision_ == poses.drive_revision()) return;
  weights_revision_ = poses.drive_revision();
  const std::vector<float>& weights = poses.morph_weights();
  if (weights.empty()) return;
  const gpu::StagingRing::Piece piece = staging.write(std::span<const float>(weights));
  recorder.pass("morph weights", {Use(shapes.weights, access::transfer_write)},
                [&](VkCommandBuffer commands) {
                  const VkBufferCopy copy{piece.offset, 0, weights.size() * sizeof(float)};
                  vkCmdCopyBuffer(commands, piece.buffer, shapes.weights.get(), 1, &copy);
                });
}

void DeformPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
                        const state::PoseState& poses) {
  DeformedShapes& shapes = scene.deformed;
  if (shapes.record_count == 0 || poses_revision_ == poses.revision()) return;
  poses_revision_ = poses.revision();
  upload_weights(recorder, staging, shapes, poses);

  gpu_types::DeformPush push{};
  push.records = shapes.records.address;
  push.groups = shapes.groups.address;
  push.sources = shapes.sources.address;
  push.influences = shapes.influences.address;
  push.joints = shapes.joints.address;
  push.joint_bounds = shapes.joint_bounds.address;
  push.deltas = shapes.deltas.address;
  push.weights = shapes.weights.address;
  push.world_from_node = scene.world_from_node.address;
  push.positions = scene.positions.address;
  push.frames = scene.frames.address;
  push.tangents = scene.tangents.address;
  push.primitives = scene.primitives.address;
  std::vector<Use> uses{Use(shapes.weights, access::compute_read),
                        Use(scene.world_from_node, access::compute_read),
                        Use(scene.positions, access::compute_write), Use(scene.frames, access::compute_write),
                        Use(scene.primitives, access::compute_write)};
  if (scene.tangents) uses.emplace_back(scene.tangents, access::compute_write);
  recorder.pass("deform", uses, [&](VkCommandBuffer commands) {
    push.group_count = shapes.group_count;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, deform_.get());
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    dispatch(commands, shapes.group_count);
    push.group_count = shapes.record_count;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, bounds_.get());
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    dispatch(commands, shapes.record_count);
  });
  levels_outdated_ = true;
}

void DeformPass::record_levels(gpu::Recorder& recorder, GpuScene& scene) {
  DeformedShapes& shapes = scene.deformed;
  if (shapes.levels.empty() || !levels_outdated_) return;
  levels_outdated_ = false;
  // Rays of the last frame read these through the top-level structure, which therefore stands in for them
  // here.
  recorder.pass(
      "deformed blas",
      {Use(scene.positions, access::build_input), Use(scene.indices, access::build_input),
       Use(shapes.levels.scratch(), access::build_write), Use(shapes.levels.storage(), access::build_write),
       Use(scene.top_level.storage(), access::build_write)},
      [&](VkCommandBuffer commands) { shapes.levels.record(commands); });
}

}  // namespace fire3dv::passes
