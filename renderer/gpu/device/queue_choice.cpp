#include "renderer/gpu/device/queue_choice.h"

namespace fire3dv::gpu {
namespace {

constexpr VkQueueFlags kBoth = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;

std::optional<uint32_t> find_family(std::span<const VkQueueFamilyProperties> families, VkQueueFlags flags) {
  for (uint32_t i = 0; i < families.size(); ++i) {
    if (families[i].queueCount > 0 && (families[i].queueFlags & kBoth) == flags) return i;
  }
  return std::nullopt;
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

}  // namespace fire3dv::gpu
