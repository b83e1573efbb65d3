#include "renderer/gpu/device.h"

#include <vk_mem_alloc.h>

#include <vector>

#include "renderer/gpu/device_features.h"

namespace fire3dv::gpu {
namespace {

uint32_t find_queue_family(VkPhysicalDevice physical) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  const VkQueueFlags needed = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  for (uint32_t i = 0; i < count; ++i) {
    if ((families[i].queueFlags & needed) == needed) return i;
  }
  FIRE3DV_ASSERT(!"a usable device has such a queue");
  return 0;
}

template <typename Function>
void load(VkDevice device, const char* name, Function& function) {
  function = reinterpret_cast<Function>(vkGetDeviceProcAddr(device, name));
}

}  // namespace

Result<std::unique_ptr<Device>> Device::create(Instance& instance, uint32_t index, bool present) {
  uint32_t count = 0;
  vkEnumeratePhysicalDevices(instance.handle(), &count, nullptr);
  std::vector<VkPhysicalDevice> devices(count);
  vkEnumeratePhysicalDevices(instance.handle(), &count, devices.data());
  FIRE3DV_ASSERT(index < count);

  std::unique_ptr<Device> device(new Device);
  device->physical_ = devices[index];
  device->report_ = report_device(devices[index], index);
  device->queue_family_ = find_queue_family(devices[index]);

  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  const bool acceleration_structures = device->report_.ray_query || device->report_.ray_tracing_pipeline;
  if (acceleration_structures) properties.pNext = &device->acceleration_;
  if (device->report_.ray_tracing_pipeline) device->acceleration_.pNext = &device->ray_pipeline_;
  vkGetPhysicalDeviceProperties2(devices[index], &properties);
  device->limits_ = properties.properties.limits;

  DeviceFeatures features;
  vkGetPhysicalDeviceFeatures2(devices[index], features.query_chain(devices[index]));
  std::vector<const char*> extensions;
  VkPhysicalDeviceFeatures2* enabled = features.enable_chain(extensions);
  if (present) extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);

  const float priority = 1;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = device->queue_family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, enabled};
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  if (VkResult result = vkCreateDevice(devices[index], &info, nullptr, &device->device_);
      result != VK_SUCCESS) {
    return Error{"cannot open " + device->report_.name + ": " + result_name(result) +
                 "; choose another with --device (see --list-devices)"};
  }
  vkGetDeviceQueue(device->device_, device->queue_family_, 0, &device->queue_);

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
  allocator.physicalDevice = device->physical_;
  allocator.device = device->device_;
  allocator.instance = instance.handle();
  allocator.vulkanApiVersion = VK_API_VERSION_1_3;
  FIRE3DV_VK(vmaCreateAllocator(&allocator, &device->allocator_));

  VkSemaphoreTypeCreateInfo timeline_type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO};
  timeline_type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
  VkSemaphoreCreateInfo timeline{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &timeline_type};
  FIRE3DV_VK(vkCreateSemaphore(device->device_, &timeline, nullptr, &device->timeline_));
  return device;
}

Device::~Device() {
  if (timeline_) {
    retire_all_now();
    vkDestroySemaphore(device_, timeline_, nullptr);
  }
  if (allocator_) vmaDestroyAllocator(allocator_);
  if (device_) vkDestroyDevice(device_, nullptr);
}

uint64_t Device::submit(VkCommandBuffer commands, std::span<const SemaphoreSignal> waits,
                        std::span<const SemaphoreSignal> signals) {
  VkCommandBufferSubmitInfo command_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
  command_info.commandBuffer = commands;

  auto semaphore_info = [](VkSemaphore semaphore, uint64_t value, VkPipelineStageFlags2 stage) {
    VkSemaphoreSubmitInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO};
    info.semaphore = semaphore;
    info.value = value;
    info.stageMask = stage;
    return info;
  };
  std::vector<VkSemaphoreSubmitInfo> wait_infos, signal_infos;
  for (const SemaphoreSignal& s : waits) wait_infos.push_back(semaphore_info(s.semaphore, 0, s.stage));
  for (const SemaphoreSignal& s : signals) signal_infos.push_back(semaphore_info(s.semaphore, 0, s.stage));
  signal_infos.push_back(semaphore_info(timeline_, submitted_ + 1, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT));

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
  // A lost device ends the wait with an error, in the destructor too; there is nothing more to wait for then.
  vkWaitSemaphores(device_, &info, UINT64_MAX);
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
      vkDestroyPipeline(device_, reinterpret_cast<VkPipeline>(object), nullptr);
      break;
    case ObjectKind::pipeline_layout:
      vkDestroyPipelineLayout(device_, reinterpret_cast<VkPipelineLayout>(object), nullptr);
      break;
    case ObjectKind::set_layout:
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
  // The commands being recorded now will be submission submitted_ + 1 and may use the object too.
  device.retired_.push_back({device.submitted_ + 1, kind, object, allocation});
}

void count_created(Device& device, ObjectKind kind) {
  device.live_[static_cast<size_t>(kind)]++;
}

}  // namespace detail
}  // namespace fire3dv::gpu
