#include "renderer/gpu/device/device.h"

#include <vk_mem_alloc.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "renderer/gpu/device/device_features.h"
#include "renderer/gpu/mask/device_mask.h"

namespace fire3dv::gpu {
namespace {

std::vector<VkQueueFamilyProperties> queue_families(VkPhysicalDevice physical) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  device_mask().apply(families);
  return families;
}

VkSemaphore create_timeline(VkDevice device) {
  VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO};
  type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
  const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type};
  VkSemaphore timeline = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateSemaphore(device, &info, nullptr, &timeline));
  return timeline;
}

std::vector<VkSemaphoreSubmitInfo> semaphore_submits(std::span<const SemaphoreSignal> semaphores) {
  std::vector<VkSemaphoreSubmitInfo> infos;
  for (const SemaphoreSignal& s : semaphores) infos.push_back(semaphore_submit(s.semaphore, 0, s.stage));
  return infos;
}

template <typename Function>
void load(VkDevice device, const char* name, Function& function) {
  function = reinterpret_cast<Function>(vkGetDeviceProcAddr(device, name));
}

}  // namespace

Result<std::unique_ptr<Device>> Device::create(Instance& instance, uint32_t index, bool present,
                                               AsyncCompute async_compute) {
  uint32_t count = 0;
  vkEnumeratePhysicalDevices(instance.handle(), &count, nullptr);
  std::vector<VkPhysicalDevice> devices(count);
  vkEnumeratePhysicalDevices(instance.handle(), &count, devices.data());
  FIRE3DV_ASSERT(index < count);

  std::unique_ptr<Device> device(new Device);
  device->physical_ = devices[index];
  device->report_ = report_device(devices[index], index);
  const bool acceleration_structures = device->report_.ray_query || device->report_.ray_tracing_pipeline;
  const std::vector<VkQueueFamilyProperties> families = queue_families(devices[index]);
  const std::optional<QueueChoice> chosen =
      choose_queues(families, acceleration_structures ? async_compute : AsyncCompute::off);
  FIRE3DV_ASSERT(chosen && "a usable device has such a queue");
  const QueueChoice& queues = device->queues_ = *chosen;
  device->timestamp_bits_ = families[queues.main_family].timestampValidBits;
  device->async_timestamp_bits_ = families[queues.async_family].timestampValidBits;

  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  if (acceleration_structures) properties.pNext = &device->acceleration_;
  if (device->report_.ray_tracing_pipeline) device->acceleration_.pNext = &device->ray_pipeline_;
  vkGetPhysicalDeviceProperties2(devices[index], &properties);
  device->limits_ = properties.properties.limits;
  device_mask().apply(device->limits_);
  device->identity_ = properties.properties;

  DeviceFeatures features;
  features.query(devices[index]);
  std::vector<const char*> extensions;
  VkPhysicalDeviceFeatures2* enabled = features.enable_chain(extensions);
  if (present) extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);

  const float priorities[] = {1, 1};
  VkDeviceQueueCreateInfo queue_infos[2]{{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO},
                                         {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO}};
  queue_infos[0].queueFamilyIndex = queues.main_family;
  queue_infos[0].queueCount = queues.async == AsyncQueue::main_family ? 2 : 1;
  queue_infos[1].queueFamilyIndex = queues.async_family;
  queue_infos[1].queueCount = 1;
  queue_infos[0].pQueuePriorities = queue_infos[1].pQueuePriorities = priorities;
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, enabled};
  info.queueCreateInfoCount = queues.two_families() ? 2 : 1;
  info.pQueueCreateInfos = queue_infos;
  info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  if (VkResult result = vkCreateDevice(devices[index], &info, nullptr, &device->device_);
      result != VK_SUCCESS) {
    return Error{"cannot open " + device->report_.name + ": " + result_name(result) +
                 "; choose another with --device (see --list-devices)"};
  }
  vkGetDeviceQueue(device->device_, queues.main_family, 0, &device->queue_);
  vkGetDeviceQueue(device->device_, queues.async_family, queues.async_index, &device->async_queue_);

  if (acceleration_structures) {
    DeviceFunctions& f = device->functions_;
    VkDevice d = device->device_;
    load(d, "vkCreateAccelerationStructureKHR", f.create_acceleration_structure);
    load(d, "vkDestroyAccelerationStructureKHR", f.destroy_acceleration_structure);
    load(d, "vkGetAccelerationStructureBuildSizesKHR", f.get_build_sizes);
    load(d, "vkGetAccelerationStructureDeviceAddressKHR", f.get_acceleration_structure_address);
    load(d, "vkCmdBuildAccelerationStructuresKHR", f.cmd_build_acceleration_structures);
    load(d, "vkCmdWriteAccelerationStructuresPropertiesKHR", f.cmd_write_acceleration_structures_properties);
    load(d, "vkCmdCopyAccelerationStructureKHR", f.cmd_copy_acceleration_structure);
    load(d, "vkCreateRayTracingPipelinesKHR", f.create_ray_tracing_pipelines);
    load(d, "vkGetRayTracingShaderGroupHandlesKHR", f.get_shader_group_handles);
    load(d, "vkCmdTraceRaysIndirectKHR", f.cmd_trace_rays_indirect);
  }

  VmaAllocatorCreateInfo allocator{};
  allocator.flags =
      VMA_ALLOCATOR_CREATE_BUFFER_DEVICE_ADDRESS_BIT | VMA_ALLOCATOR_CREATE_EXTERNALLY_SYNCHRONIZED_BIT;
  if (features.memory_budget) allocator.flags |= VMA_ALLOCATOR_CREATE_EXT_MEMORY_BUDGET_BIT;
  allocator.physicalDevice = device->physical_;
  allocator.device = device->device_;
  allocator.instance = instance.handle();
  allocator.vulkanApiVersion = VK_API_VERSION_1_3;
  FIRE3DV_VK(vmaCreateAllocator(&allocator, &device->allocator_));
  const VkPhysicalDeviceMemoryProperties* memory = nullptr;
  vmaGetMemoryProperties(device->allocator_, &memory);
  for (uint32_t heap = 0; heap < memory->memoryHeapCount; ++heap) {
    if (memory->memoryHeaps[heap].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
      device->memory_bytes_ = std::max(device->memory_bytes_, memory->memoryHeaps[heap].size);
  }

  device->timeline_ = create_timeline(device->device_);
  device->fork_timeline_ = create_timeline(device->device_);
  return device;
}

Device::~Device() {
  pipeline_makers_.reset();
  if (timeline_) {
    retire_all_now();
    pipeline_keeper_.destroy_all(device_);
    vkDestroySemaphore(device_, timeline_, nullptr);
    if (fork_timeline_) vkDestroySemaphore(device_, fork_timeline_, nullptr);
  }
  if (pipeline_cache_) vkDestroyPipelineCache(device_, pipeline_cache_, nullptr);
  if (allocator_) vmaDestroyAllocator(allocator_);
  if (device_) vkDestroyDevice(device_, nullptr);
}

void Device::start_pipeline_cache(std::span<const std::byte> kept) {
  FIRE3DV_ASSERT(!pipeline_cache_);
  // Not every driver checks the header of cached data carefully.
  VkPipelineCacheHeaderVersionOne header{};
  if (kept.size() >= sizeof(header)) std::memcpy(&header, kept.data(), sizeof(header));
  const bool ours = kept.size() > sizeof(header) && header.headerSize == sizeof(header) &&
                    header.headerVersion == VK_PIPELINE_CACHE_HEADER_VERSION_ONE &&
                    header.vendorID == identity_.vendorID && header.deviceID == identity_.deviceID &&
                    std::memcmp(header.pipelineCacheUUID, identity_.pipelineCacheUUID, VK_UUID_SIZE) == 0;
  VkPipelineCacheCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
  info.initialDataSize = ours ? kept.size() : 0;
  info.pInitialData = kept.data();
  FIRE3DV_VK(vkCreatePipelineCache(device_, &info, nullptr, &pipeline_cache_));
}

std::vector<std::byte> Device::pipeline_cache_data() const {
  size_t size = 0;
  if (!pipeline_cache_ || vkGetPipelineCacheData(device_, pipeline_cache_, &size, nullptr) != VK_SUCCESS)
    return {};
  std::vector<std::byte> data(size);
  if (vkGetPipelineCacheData(device_, pipeline_cache_, &size, data.data()) != VK_SUCCESS) return {};
  data.resize(size);
  if (data.size() <= sizeof(VkPipelineCacheHeaderVersionOne)) data.clear();
  return data;
}

uint64_t Device::submit(VkCommandBuffer commands, std::span<const SemaphoreSignal> waits,
                        std::span<const SemaphoreSignal> signals) {
  VkCommandBufferSubmitInfo command_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
  command_info.commandBuffer = commands;
  const std::vector<VkSemaphoreSubmitInfo> wait_infos = semaphore_submits(waits);
  std::vector<VkSemaphoreSubmitInfo> signal_infos = semaphore_submits(signals);
  signal_infos.push_back(semaphore_submit(timeline_, submitted_ + 1));

  VkSubmitInfo2 info{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
  info.commandBufferInfoCount = 1;
  info.pCommandBufferInfos = &command_info;
  info.waitSemaphoreInfoCount = static_cast<uint32_t>(wait_infos.size());
  info.pWaitSemaphoreInfos = wait_infos.data();
  info.signalSemaphoreInfoCount = static_cast<uint32_t>(signal_infos.size());
  info.pSignalSemaphoreInfos = signal_infos.data();
  FIRE3DV_VK(vkQueueSubmit2(queue_, 1, &info, VK_NULL_HANDLE));
  return ++submitted_;
}

uint64_t Device::submit(const ForkedCommands& commands, std::span<const SemaphoreSignal> waits,
                        std::span<const SemaphoreSignal> signals) {
  std::vector<VkSemaphoreSubmitInfo> signal_infos = semaphore_submits(signals);
  signal_infos.push_back(semaphore_submit(timeline_, submitted_ + 1));
  const ForkedSubmit fork(commands, fork_timeline_, ++forks_submitted_, semaphore_submits(waits),
                          std::move(signal_infos));
  FIRE3DV_VK(vkQueueSubmit2(queue_, 1, &fork.before(), VK_NULL_HANDLE));
  FIRE3DV_VK(vkQueueSubmit2(async_queue_, 1, &fork.async_compute(), VK_NULL_HANDLE));
  FIRE3DV_VK(
      vkQueueSubmit2(queue_, static_cast<uint32_t>(fork.rest().size()), fork.rest().data(), VK_NULL_HANDLE));
  return ++submitted_;
}

uint64_t Device::completed() const {
  uint64_t value = 0;
  FIRE3DV_VK(vkGetSemaphoreCounterValue(device_, timeline_, &value));
  return value;
}

void Device::wait(uint64_t value) const {
  VkSemaphoreWaitInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO};
  info.semaphoreCount = 1;
  info.pSemaphores = &timeline_;
  info.pValues = &value;
  // A lost device ends the wait with an error, also in the destructor. No work is left to wait for in that
  // case.
  vkWaitSemaphores(device_, &info, UINT64_MAX);
}

bool Device::wait_for(uint64_t value, int64_t timeout_ns) const {
  VkSemaphoreWaitInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO};
  info.semaphoreCount = 1;
  info.pSemaphores = &timeline_;
  info.pValues = &value;
  const uint64_t timeout = timeout_ns > 0 ? static_cast<uint64_t>(timeout_ns) : 0;
  return vkWaitSemaphores(device_, &info, timeout) == VK_SUCCESS;
}

void Device::collect() {
  if (retired_.empty()) return;
  const uint64_t done = completed();
  while (!retired_.empty() && retired_.front().after <= done) {
    destroy(retired_.front());
    retired_.pop_front();
  }
}

void Device::retire_all_now() {
  wait(submitted_);
  for (const Retired& retired : retired_) destroy(retired);
  retired_.clear();
}

uint64_t Device::allocated_bytes() const {
  VmaTotalStatistics statistics;
  vmaCalculateStatistics(allocator_, &statistics);
  return statistics.total.statistics.allocationBytes;
}

uint64_t Device::available_bytes() const {
  const VkPhysicalDeviceMemoryProperties* memory = nullptr;
  vmaGetMemoryProperties(allocator_, &memory);
  std::array<VmaBudget, VK_MAX_MEMORY_HEAPS> budgets{};
  vmaGetHeapBudgets(allocator_, budgets.data());
  uint64_t available = 0;
  for (uint32_t heap = 0; heap < memory->memoryHeapCount; ++heap) {
    if (!(memory->memoryHeaps[heap].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)) continue;
    const VmaBudget& budget = budgets[heap];
    if (budget.budget > budget.usage) available = std::max(available, budget.budget - budget.usage);
  }
  return available;
}

void Device::begin_allocation() {
  if (allocations_until_failure_ == UINT64_MAX || allocations_until_failure_ == 0) return;
  if (--allocations_until_failure_ == 0)
    throw VulkanFailure(VK_ERROR_OUT_OF_DEVICE_MEMORY, "an allocation that a test lets fail");
}

void Device::destroy(const Retired& retired) {
  live_[static_cast<size_t>(retired.kind)]--;
  const uint64_t object = retired.object;
  switch (retired.kind) {
    case ObjectKind::buffer:
      vmaDestroyBuffer(allocator_, reinterpret_cast<VkBuffer>(object), retired.allocation);
      break;
    case ObjectKind::image:
      vmaDestroyImage(allocator_, reinterpret_cast<VkImage>(object), retired.allocation);
      break;
    case ObjectKind::image_view:
      vkDestroyImageView(device_, reinterpret_cast<VkImageView>(object), nullptr);
      break;
    case ObjectKind::sampler:
      vkDestroySampler(device_, reinterpret_cast<VkSampler>(object), nullptr);
      break;
    case ObjectKind::shader_module:
      vkDestroyShaderModule(device_, reinterpret_cast<VkShaderModule>(object), nullptr);
      break;
    case ObjectKind::pipeline:
      if (!pipeline_keeper_.holds(reinterpret_cast<VkPipeline>(object)))
        vkDestroyPipeline(device_, reinterpret_cast<VkPipeline>(object), nullptr);
      break;
    case ObjectKind::pipeline_layout:
      if (pipeline_keeper_.holds(reinterpret_cast<VkPipelineLayout>(object))) break;
      pipeline_keeper_.forget(reinterpret_cast<VkPipelineLayout>(object));
      vkDestroyPipelineLayout(device_, reinterpret_cast<VkPipelineLayout>(object), nullptr);
      break;
    case ObjectKind::set_layout:
      pipeline_keeper_.forget(reinterpret_cast<VkDescriptorSetLayout>(object));
      vkDestroyDescriptorSetLayout(device_, reinterpret_cast<VkDescriptorSetLayout>(object), nullptr);
      break;
    case ObjectKind::descriptor_pool:
      vkDestroyDescriptorPool(device_, reinterpret_cast<VkDescriptorPool>(object), nullptr);
      break;
    case ObjectKind::query_pool:
      vkDestroyQueryPool(device_, reinterpret_cast<VkQueryPool>(object), nullptr);
      break;
    case ObjectKind::command_pool:
      vkDestroyCommandPool(device_, reinterpret_cast<VkCommandPool>(object), nullptr);
      break;
    case ObjectKind::semaphore:
      vkDestroySemaphore(device_, reinterpret_cast<VkSemaphore>(object), nullptr);
      break;
    case ObjectKind::acceleration_structure:
      functions_.destroy_acceleration_structure(device_, reinterpret_cast<VkAccelerationStructureKHR>(object),
                                                nullptr);
      break;
    case ObjectKind::swapchain:
      vkDestroySwapchainKHR(device_, reinterpret_cast<VkSwapchainKHR>(object), nullptr);
      break;
  }
}

const char* object_kind_name(ObjectKind kind) {
  constexpr const char* names[kObjectKinds] = {"buffer",
                                               "image",
                                               "image view",
                                               "sampler",
                                               "shader module",
                                               "pipeline",
                                               "pipeline layout",
                                               "set layout",
                                               "descriptor pool",
                                               "query pool",
                                               "command pool",
                                               "semaphore",
                                               "acceleration structure",
                                               "swapchain"};
  return names[static_cast<size_t>(kind)];
}

namespace detail {

void retire(Device& device, ObjectKind kind, uint64_t object, VmaAllocation_T* allocation) {
  // The commands being recorded become submission submitted_ + 1 and may use the object, too.
  device.retired_.push_back({device.submitted_ + 1, kind, object, allocation});
}

void count_created(Device& device, ObjectKind kind) {
  device.live_[static_cast<size_t>(kind)]++;
}

}  // namespace detail
}  // namespace fire3dv::gpu
