#include "renderer/gpu/device/queues.h"

#include <utility>

namespace fire3dv::gpu {
namespace {

constexpr VkQueueFlags kBoth = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;

std::optional<uint32_t> find_family(std::span<const VkQueueFamilyProperties> families, VkQueueFlags flags) {
  for (uint32_t i = 0; i < families.size(); ++i) {
    if (families[i].queueCount > 0 && (families[i].queueFlags & kBoth) == flags) return i;
  }
  return std::nullopt;
}

void set_waits(VkSubmitInfo2& submit, std::span<const VkSemaphoreSubmitInfo> waits) {
  submit.waitSemaphoreInfoCount = static_cast<uint32_t>(waits.size());
  submit.pWaitSemaphoreInfos = waits.data();
}

void set_signals(VkSubmitInfo2& submit, std::span<const VkSemaphoreSubmitInfo> signals) {
  submit.signalSemaphoreInfoCount = static_cast<uint32_t>(signals.size());
  submit.pSignalSemaphoreInfos = signals.data();
}

}  // namespace

std::optional<QueueChoice> choose_queues(std::span<const VkQueueFamilyProperties> families,
                                         AsyncCompute wanted) {
  const std::optional<uint32_t> main = find_family(families, kBoth);
  if (!main) return std::nullopt;
  QueueChoice choice;
  choice.main_family = choice.async_family = *main;
  if (wanted == AsyncCompute::off) return choice;
  if (const std::optional<uint32_t> compute = find_family(families, VK_QUEUE_COMPUTE_BIT)) {
    choice.async = AsyncQueue::compute_family;
    choice.async_family = *compute;
  } else if (families[*main].queueCount > 1) {
    choice.async = AsyncQueue::main_family;
    choice.async_index = 1;
  } else if (wanted == AsyncCompute::on) {
    choice.async = AsyncQueue::main_queue;
  }
  return choice;
}

const char* describe(AsyncQueue async) {
  switch (async) {
    case AsyncQueue::none:
      return "on the main queue";
    case AsyncQueue::compute_family:
      return "on an async compute queue";
    case AsyncQueue::main_family:
      return "on a second queue of the main family";
    case AsyncQueue::main_queue:
      return "in separate submissions on the main queue (no async compute queue)";
  }
  return "on the main queue";
}

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
