#include "renderer/passes/resources/transforms_pass.h"

#include <cstring>

#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

gpu_types::AffineRows to_rows(const wire::Affine3x4& affine) {
  gpu_types::AffineRows rows;
  static_assert(sizeof(rows) == sizeof(affine));
  std::memcpy(&rows, affine.m.data(), sizeof(rows));
  return rows;
}

gpu_types::AffineRows to_rows(const wire::Affine3x4d& affine) {
  wire::Affine3x4 single;
  for (size_t i = 0; i < 12; ++i) single.m[i] = static_cast<float>(affine.m[i]);
  return to_rows(single);
}

}  // namespace

TransformsPass::TransformsPass(gpu::Device& device, VkPipelineLayout layout)
    : device_(device),
      layout_(layout),
      pipeline_(gpu::create_compute_pipeline(device, layout, "transforms.comp")) {}

void TransformsPass::invalidate() {
  uploaded_drives_ = UINT64_MAX;
  streams_.clear();
}

void TransformsPass::upload_drives(gpu::Recorder& recorder, gpu::StagingRing& staging,
                                   const state::PoseState& poses) {
  if (uploaded_drives_ == poses.drive_revision()) return;
  std::vector<gpu_types::NodeSource> sources;
  sources.reserve(poses.node_drives().size());
  for (const state::NodeDrive& drive : poses.node_drives()) {
    sources.push_back({to_rows(drive.body_from_node), drive.stream, drive.pose_index});
  }
  const VkDeviceSize bytes = sources.size() * sizeof(gpu_types::NodeSource);
  if (!sources_ || sources_.size_bytes < bytes) {
    sources_ = gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
  }
  const gpu::StagingRing::Piece piece = staging.write(std::span<const gpu_types::NodeSource>(sources));
  recorder.pass("drives", {Use(sources_, access::transfer_write)}, [&](VkCommandBuffer commands) {
    const VkBufferCopy copy{piece.offset, 0, bytes};
    if (bytes) vkCmdCopyBuffer(commands, piece.buffer, sources_.get(), 1, &copy);
  });
  uploaded_drives_ = poses.drive_revision();
}

void TransformsPass::upload_poses(gpu::Recorder& recorder, gpu::StagingRing& staging,
                                  const state::PoseState& poses) {
  const std::vector<state::Stream>& streams = poses.streams();
  streams_.resize(streams.size());
  struct Copy {
    VkBuffer from, to;
    VkBufferCopy region;
  };
  std::vector<Copy> copies;
  std::vector<Use> uses;
  for (size_t s = 0; s < streams.size(); ++s) {
    StreamPoses& uploaded = streams_[s];
    const state::Stream& stream = streams[s];
    if (stream.poses.empty() || (uploaded.epoch == stream.epoch && uploaded.revision == stream.revision))
      continue;
    const VkDeviceSize bytes = stream.poses.size() * sizeof(wire::Affine3x4);
    if (!uploaded.poses || uploaded.poses.size_bytes < bytes) {
      uploaded.poses =
          gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
    }
    const gpu::StagingRing::Piece piece = staging.write(std::span<const wire::Affine3x4>(stream.poses));
    copies.push_back({piece.buffer, uploaded.poses.get(), {piece.offset, 0, bytes}});
    uses.emplace_back(uploaded.poses, access::transfer_write);
    uploaded.epoch = stream.epoch;
    uploaded.revision = stream.revision;
  }
  if (copies.empty()) return;
  recorder.pass("poses", uses,
                [&](VkCommandBuffer commands) {  // one pass for all streams, since timestamp queries are
                                                 // limited
                  for (const Copy& copy : copies)
                    vkCmdCopyBuffer(commands, copy.from, copy.to, 1, &copy.region);
                });
}

void TransformsPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
                            const state::PoseState& poses) {
  upload_drives(recorder, staging, poses);
  upload_poses(recorder, staging, poses);
  if (scene.node_count == 0) return;

  std::vector<gpu_types::StreamSource> stream_sources;
  std::vector<Use> uses{Use(sources_, access::compute_read),
                        Use(scene.world_from_node, access::compute_write)};
  for (size_t s = 0; s < streams_.size(); ++s) {
    stream_sources.push_back({streams_[s].poses.address, to_rows(poses.streams()[s].world_from_stream)});
    if (streams_[s].poses) uses.emplace_back(streams_[s].poses, access::compute_read);
  }
  if (scene.instances) uses.emplace_back(scene.instances, access::compute_write);

  gpu_types::TransformsPush push{};
  push.sources = sources_.address;
  push.streams = staging.write(std::span<const gpu_types::StreamSource>(stream_sources)).address;
  push.world_from_node = scene.world_from_node.address;
  push.instance_of_node = scene.instance_of_node.address;
  push.instances = scene.instances.address;
  push.node_facts = scene.node_facts();
  push.light_of_node = scene.light_of_node.address;
  push.lights = scene.lights.address;
  push.light_poses = scene.light_poses();
  push.node_count = scene.node_count;
  recorder.pass("transforms", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, (scene.node_count + 63) / 64, 1, 1);
  });
}

}  // namespace fire3dv::passes
