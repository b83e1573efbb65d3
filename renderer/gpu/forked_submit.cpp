#include "renderer/gpu/forked_submit.h"

namespace fire3dv::gpu {
namespace {

void set_waits(VkSubmitInfo2& submit, std::span<const VkSemaphoreSubmitInfo> waits) {
  submit.waitSemaphoreInfoCount = static_cast<uint32_t>(waits.size());
  submit.pWaitSemaphoreInfos = waits.data();
}

void set_signals(VkSubmitInfo2& submit, std::span<const VkSemaphoreSubmitInfo> signals) {
  submit.signalSemaphoreInfoCount = static_cast<uint32_t>(signals.size());
  submit.pSignalSemaphoreInfos = signals.data();
}

}  // namespace

VkSemaphoreSubmitInfo semaphore_submit(VkSemaphore semaphore, uint64_t value, VkPipelineStageFlags2 stage) {
  VkSemaphoreSubmitInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO};
  info.semaphore = semaphore;
  info.value = value;
  info.stageMask = stage;
  return info;
}

ForkedSubmit::ForkedSubmit(const ForkedCommands& commands, VkSemaphore fork_timeline, uint64_t number,
                           std::vector<VkSemaphoreSubmitInfo> waits,
                           std::vector<VkSemaphoreSubmitInfo> signals)
    : before_done_(semaphore_submit(fork_timeline, 2 * number - 1)),
      async_done_(semaphore_submit(fork_timeline, 2 * number)),
      waits_(std::move(waits)),
      signals_(std::move(signals)) {
  const VkCommandBuffer pieces[] = {commands.before, commands.async_compute, commands.overlapped,
                                    commands.after};
  for (size_t i = 0; i < submits_.size(); ++i) {
    commands_[i].sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO;
    commands_[i].commandBuffer = pieces[i];
    submits_[i].sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2;
    submits_[i].commandBufferInfoCount = 1;
    submits_[i].pCommandBufferInfos = &commands_[i];
  }
  waits_.push_back(async_done_);
  set_signals(submits_[0], {&before_done_, 1});
  set_waits(submits_[1], {&before_done_, 1});
  set_signals(submits_[1], {&async_done_, 1});
  set_waits(submits_[3], waits_);
  set_signals(submits_[3], signals_);
}

}  // namespace fire3dv::gpu
