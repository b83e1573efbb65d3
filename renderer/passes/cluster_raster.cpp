#include "renderer/passes/cluster_raster.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>

#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

constexpr uint32_t kPreparedCapacity = 1u << 18;
constexpr uint32_t kTileCapacity = 1u << 20;
constexpr uint32_t kHugeAtFirst = 1u << 22;  // 32 MiB, of scenes that large
constexpr gpu::Access kArgumentsAndCompute{
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
    VK_ACCESS_2_SHADER_READ_BIT | VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, true};

void grow(gpu::Device& device, gpu::Buffer& buffer, VkDeviceSize bytes, VkBufferUsageFlags more_usage = 0) {
  if (buffer && buffer.size_bytes >= bytes) return;
  buffer =
      gpu::create_buffer(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | more_usage, gpu::Memory::device);
}

}  // namespace

ClusterRaster::ClusterRaster(gpu::Device& device, VkPipelineLayout layout, RasterKind kind)
    : device_(device), layout_(layout) {
  const std::string suffix = kind == RasterKind::lights             ? "_light.comp"
                             : kind == RasterKind::camera_4_samples ? "_4.comp"
                                                                    : "_1.comp";
  cull_ = gpu::create_compute_pipeline(device, layout,
                                       kind == RasterKind::lights ? "cull_light.comp" : "cull.comp");
  raster_ = gpu::create_compute_pipeline(device, layout, "raster" + suffix);
  raster_mask_ = gpu::create_compute_pipeline(device, layout, "raster_mask" + suffix);
  expand_ = gpu::create_compute_pipeline(device, layout, "expand" + suffix);
  tiles_ = gpu::create_compute_pipeline(device, layout, "tiles" + suffix);
  for (gpu::Buffer& seen : large_seen_) {
    seen = gpu::create_buffer(device, sizeof(gpu_types::LargeWork), 0, gpu::Memory::readback);
    std::memset(seen.mapped, 0, sizeof(gpu_types::LargeWork));
  }
}

void ClusterRaster::make_room(const Job& job) {
  // This slot's earlier frame is done, so what it counted can be read.
  gpu_types::LargeWork seen;
  std::memcpy(&seen, large_seen_[frame_ % gpu::kFramesInFlight].mapped, sizeof(seen));
  while (seen.expand.count > huge_capacity_ && huge_capacity_ < (1u << 27)) huge_capacity_ *= 2;

  const VkDeviceSize entries = VkDeviceSize{job.view_count} * job.scene->cluster_instance_count;
  // Room for every triangle of a scene that is not vast, so that the first image lacks none.
  while (huge_capacity_ < kHugeAtFirst && huge_capacity_ < entries * scene::kClusterTriangles)
    huge_capacity_ *= 2;
  grow(device_, lists_, entries * sizeof(uint32_t));
  grow(device_, work_, job.view_count * sizeof(gpu_types::ViewWork), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
  grow(device_, large_, sizeof(gpu_types::LargeWork), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT);
  grow(device_, huge_, VkDeviceSize{huge_capacity_} * sizeof(gpu_types::HugeTriangle));
  grow(device_, prepared_, VkDeviceSize{kPreparedCapacity} * sizeof(gpu_types::PreparedTriangle));
  grow(device_, tile_entries_, VkDeviceSize{kTileCapacity} * sizeof(gpu_types::TileEntry));
}

void ClusterRaster::begin(gpu::UploadBelt& belt, const Job& job) {
  job_ = job;
  make_room(job);
  gpu_types::RasterSet set{};
  set.views = job.views;
  set.work = work_.address;
  set.lists = lists_.address;
  set.large = large_.address;
  set.huge = huge_.address;
  set.prepared = prepared_.address;
  set.tiles = tile_entries_.address;
  set.target = job.target->address;
  set.instance_count = job.scene->cluster_instance_count;
  set.huge_capacity = huge_capacity_;
  set.prepared_capacity = kPreparedCapacity;
  set.tile_capacity = kTileCapacity;
  set.cull = job.cull ? 1 : 0;
  set_ = belt.write(std::span<const gpu_types::RasterSet>(&set, 1)).address;
}

void ClusterRaster::add_uses(std::vector<Use>& uses, bool large) {
  job_.scene->add_reads(uses, access::compute_read);
  if (job_.views_written) uses.emplace_back(*job_.views_written, access::compute_read);
  uses.emplace_back(work_, kArgumentsAndCompute);
  uses.emplace_back(lists_, access::compute_write);
  uses.emplace_back(large_, kArgumentsAndCompute);
  uses.emplace_back(huge_, access::compute_write);
  uses.emplace_back(prepared_, access::compute_write);
  uses.emplace_back(tile_entries_, access::compute_write);
  // The target is not declared from stage to stage: the largest value wins in any order, and atomics need no
  // barrier.
  if (!large) uses.emplace_back(*job_.target, access::compute_write);
}

void ClusterRaster::clear(VkCommandBuffer commands) {
  vkCmdFillBuffer(commands, work_.get(), 0, VK_WHOLE_SIZE, 0);
  vkCmdFillBuffer(commands, large_.get(), 0, VK_WHOLE_SIZE, 0);
  vkCmdFillBuffer(commands, job_.target->get(), 0, VK_WHOLE_SIZE, 0);
}

void ClusterRaster::bind(VkCommandBuffer commands, const gpu::Pipeline& pipeline, uint32_t view) const {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
  const VkDescriptorSet set = job_.scene->textures.set();
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
  const gpu_types::RasterPush push{job_.globals, set_, view};
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
}

void ClusterRaster::cull(VkCommandBuffer commands) const {
  bind(commands, cull_, 0);
  const uint32_t groups = (job_.scene->cluster_instance_count + 63) / 64;
  if (groups) vkCmdDispatch(commands, std::min(groups, 65535u), (groups + 65534) / 65535, job_.view_count);
}

void ClusterRaster::raster(VkCommandBuffer commands) const {
  for (uint32_t view = 0; view < job_.view_count; ++view) {
    const VkDeviceSize work = view * sizeof(gpu_types::ViewWork);
    bind(commands, raster_, view);
    vkCmdDispatchIndirect(commands, work_.get(), work + offsetof(gpu_types::ViewWork, solid));
    if (!job_.scene->has_masked) continue;
    bind(commands, raster_mask_, view);
    vkCmdDispatchIndirect(commands, work_.get(), work + offsetof(gpu_types::ViewWork, masked));
  }
}

void ClusterRaster::large_stage(VkCommandBuffer commands, const gpu::Pipeline& pipeline,
                                VkDeviceSize arguments) const {
  bind(commands, pipeline, 0);
  vkCmdDispatchIndirect(commands, large_.get(), arguments);
}

void ClusterRaster::record(gpu::Recorder& recorder, std::span<ClusterRaster* const> sets) {
  auto stage = [&](const char* name, auto&& add_uses, auto&& commands_of) {
    std::vector<Use> uses;
    for (ClusterRaster* set : sets) add_uses(*set, uses);
    recorder.pass(name, uses, [&](VkCommandBuffer commands) {
      for (ClusterRaster* set : sets) commands_of(*set, commands);
    });
  };
  auto first_uses = [](ClusterRaster& set, std::vector<Use>& uses) { set.add_uses(uses, false); };
  auto large_uses = [](ClusterRaster& set, std::vector<Use>& uses) { set.add_uses(uses, true); };

  stage(
      "clear",
      [](ClusterRaster& set, std::vector<Use>& uses) {
        uses.emplace_back(set.work_, access::transfer_write);
        uses.emplace_back(set.large_, access::transfer_write);
        uses.emplace_back(*set.job_.target, access::transfer_write);
      },
      [](ClusterRaster& set, VkCommandBuffer commands) { set.clear(commands); });
  stage("cull", large_uses, [](ClusterRaster& set, VkCommandBuffer commands) { set.cull(commands); });
  stage("raster", first_uses, [](ClusterRaster& set, VkCommandBuffer commands) { set.raster(commands); });
  stage("expand", large_uses, [](ClusterRaster& set, VkCommandBuffer commands) {
    set.large_stage(commands, set.expand_, offsetof(gpu_types::LargeWork, expand));
  });
  stage("tiles", large_uses, [](ClusterRaster& set, VkCommandBuffer commands) {
    set.large_stage(commands, set.tiles_, offsetof(gpu_types::LargeWork, tiles));
  });

  for (ClusterRaster* set : sets) {
    gpu::Buffer& seen = set->large_seen_[set->frame_++ % gpu::kFramesInFlight];
    recorder.transition({Use(set->large_, access::transfer_read), Use(seen, access::transfer_write)});
    const VkBufferCopy copy{0, 0, sizeof(gpu_types::LargeWork)};
    vkCmdCopyBuffer(recorder.commands(), set->large_.get(), seen.get(), 1, &copy);
    recorder.transition({Use(seen, access::host_read)});
  }
}

}  // namespace fire3dv::passes
