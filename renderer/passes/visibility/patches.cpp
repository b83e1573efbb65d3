#include "renderer/passes/visibility/patches.h"

namespace fire3dv::passes {
namespace {

constexpr VkPipelineStageFlags2 kAll = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                kTransfer = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
using gpu::wait_for;

}  // namespace

void Patches::reserve(gpu::Device& device, gpu::Buffer& buffer, VkDeviceSize used_bytes, VkDeviceSize bytes) {
  if (buffer.size_bytes >= bytes) return;
  gpu::Buffer larger =
      gpu::create_buffer(device, bytes + bytes / 2, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
  if (used_bytes) moves_.push_back({buffer.get(), larger.get(), {0, 0, used_bytes}});
  buffer = std::move(larger);  // the old buffer outlives the frame being recorded
}

void Patches::record(gpu::Recorder& recorder, gpu::StagingRing& staging) {
  if (empty()) return;
  const gpu::StagingRing::Piece piece = staging.write(std::span<const std::byte>(bytes_));
  recorder.pass("edits", {}, [&](VkCommandBuffer commands) {
    wait_for(commands, kAll, kTransfer);
    for (const Copy& move : moves_) vkCmdCopyBuffer(commands, move.from, move.to, 1, &move.region);
    if (!moves_.empty()) wait_for(commands, kTransfer, kTransfer);
    for (Copy copy : uploads_) {
      if (!copy.from) copy.region.srcOffset += piece.offset;
      vkCmdCopyBuffer(commands, copy.from ? copy.from : piece.buffer, copy.to, 1, &copy.region);
    }
    wait_for(commands, kTransfer, kAll);
  });
}

}  // namespace fire3dv::passes
