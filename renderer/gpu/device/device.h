// Logical device: its queues, timeline semaphore, memory allocator and deferred destruction. For one thread.
// More than 60 members: submission, memory and destruction share the timeline; the others are accessors.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/error.h"
#include "renderer/gpu/device/device_report.h"
#include "renderer/gpu/device/handle.h"
#include "renderer/gpu/device/pipeline_builder.h"
#include "renderer/gpu/device/pipeline_keeper.h"
#include "renderer/gpu/device/queues.h"
#include "renderer/gpu/device/vk.h"

struct VmaAllocator_T;

namespace fire3dv::gpu {

// Entry points of extensions; null when the device lacks the extension.
struct DeviceFunctions {
  PFN_vkCreateAccelerationStructureKHR create_acceleration_structure = nullptr;
  PFN_vkDestroyAccelerationStructureKHR destroy_acceleration_structure = nullptr;
  PFN_vkGetAccelerationStructureBuildSizesKHR get_build_sizes = nullptr;
  PFN_vkGetAccelerationStructureDeviceAddressKHR get_acceleration_structure_address = nullptr;
  PFN_vkCmdBuildAccelerationStructuresKHR cmd_build_acceleration_structures = nullptr;
  PFN_vkCmdWriteAccelerationStructuresPropertiesKHR cmd_write_acceleration_structures_properties = nullptr;
  PFN_vkCmdCopyAccelerationStructureKHR cmd_copy_acceleration_structure = nullptr;
  PFN_vkCreateRayTracingPipelinesKHR create_ray_tracing_pipelines = nullptr;
  PFN_vkGetRayTracingShaderGroupHandlesKHR get_shader_group_handles = nullptr;
  PFN_vkCmdTraceRaysIndirectKHR cmd_trace_rays_indirect = nullptr;
};

struct SemaphoreSignal {
  VkSemaphore semaphore = VK_NULL_HANDLE;
  VkPipelineStageFlags2 stage = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
};

class Device {
 public:
  // present: also enables the swapchain extension.
  static Result<std::unique_ptr<Device>> create(Instance& instance, uint32_t index, bool present,
                                                AsyncCompute async_compute = AsyncCompute::automatic);
  ~Device();  // waits for the last submission: for shutdown only
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  VkDevice handle() const { return device_; }
  VkPhysicalDevice physical() const { return physical_; }
  VkQueue queue() const { return queue_; }
  uint32_t queue_family() const { return queues_.main_family; }
  const QueueChoice& queues() const { return queues_; }
  // Valid bits of the queue's timestamps; 0: the queue writes none.
  uint32_t timestamp_bits() const { return timestamp_bits_; }
  uint32_t async_timestamp_bits() const { return async_timestamp_bits_; }
  VmaAllocator_T* allocator() const { return allocator_; }
  const DeviceFunctions& functions() const { return functions_; }
  const DeviceReport& report() const { return report_; }
  const VkPhysicalDeviceLimits& limits() const { return limits_; }
  const VkPhysicalDeviceAccelerationStructurePropertiesKHR& acceleration_limits() const {
    return acceleration_;
  }
  const VkPhysicalDeviceRayTracingPipelinePropertiesKHR& ray_pipeline_limits() const { return ray_pipeline_; }
  bool ray_query() const { return report_.ray_query; }
  PipelineMakers& pipeline_makers() { return *pipeline_makers_; }
  PipelineKeeper& pipeline_keeper() { return pipeline_keeper_; }
  VkPipelineCache pipeline_cache() const { return pipeline_cache_; }

  // Loads cached pipeline data of an earlier run; data of another device or driver is ignored. Call it before
  // any pipeline is created.
  void start_pipeline_cache(std::span<const std::byte> kept);
  std::vector<std::byte> pipeline_cache_data() const;  // empty where the driver caches nothing
  // Cache key of pipeline data: vendor, device, driver version and cache UUID.
  const VkPhysicalDeviceProperties& identity() const { return identity_; }

  bool traces_rays() const { return report_.ray_query || report_.ray_tracing_pipeline; }

  // Submits one command buffer. Returns the timeline value of its completion.
  uint64_t submit(VkCommandBuffer commands, std::span<const SemaphoreSignal> waits = {},
                  std::span<const SemaphoreSignal> signals = {});
  // Submits a frame with work on the async compute queue. Returns one timeline value for both queues.
  uint64_t submit(const ForkedCommands& commands, std::span<const SemaphoreSignal> waits = {},
                  std::span<const SemaphoreSignal> signals = {});
  uint64_t new_fork_number() { return ++fork_numbers_; }
  uint64_t last_submitted() const { return submitted_; }
  uint64_t completed() const;
  void wait(uint64_t value) const;                          // for one submission; does not idle the device
  bool wait_for(uint64_t value, int64_t timeout_ns) const;  // true when the submission is done

  // Destroys retired objects that no submission in flight can use. Call it once a frame.
  void collect();
  // Waits for the last submission and destroys all retired objects. Call it when a surface or the program
  // ends.
  void retire_all_now();
  const LiveObjects& live_objects() const { return live_; }
  uint64_t allocated_bytes() const;
  // Bytes of device-local memory, or of host memory where the device has none of its own.
  uint64_t memory_bytes() const { return memory_bytes_; }
  // Bytes of memory_bytes() that can still be allocated: the driver's figure (VK_EXT_memory_budget), or an
  // estimate.
  uint64_t available_bytes() const;
  // For tests: the allocation after the next `count` allocations fails once with out-of-memory.
  void fail_allocation_after(uint64_t count) { allocations_until_failure_ = count + 1; }
  bool has_failed_allocation() const { return allocations_until_failure_ == 0; }
  // Called before each allocation of a buffer or an image. Throws the failure that a test has requested.
  void begin_allocation();

 private:
  friend void detail::retire(Device&, ObjectKind, uint64_t, VmaAllocation_T*);
  friend void detail::count_created(Device&, ObjectKind);
  struct Retired {
    uint64_t after;  // timeline value
    ObjectKind kind;
    uint64_t object;
    VmaAllocation_T* allocation;
  };
  Device() = default;
  void destroy(const Retired& retired);

  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE, async_queue_ = VK_NULL_HANDLE;
  QueueChoice queues_;
  uint32_t timestamp_bits_ = 0, async_timestamp_bits_ = 0;
  VmaAllocator_T* allocator_ = nullptr;
  DeviceFunctions functions_;
  DeviceReport report_;
  VkPhysicalDeviceLimits limits_{};
  VkPhysicalDeviceAccelerationStructurePropertiesKHR acceleration_{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
  VkPhysicalDeviceRayTracingPipelinePropertiesKHR ray_pipeline_{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR};
  VkPhysicalDeviceProperties identity_{};
  VkPipelineCache pipeline_cache_ = VK_NULL_HANDLE;
  VkSemaphore timeline_ = VK_NULL_HANDLE, fork_timeline_ = VK_NULL_HANDLE;
  uint64_t submitted_ = 0, forks_submitted_ = 0, fork_numbers_ = 0;
  std::deque<Retired> retired_;
  LiveObjects live_{};
  uint64_t memory_bytes_ = 0;
  uint64_t allocations_until_failure_ = UINT64_MAX;
  PipelineKeeper pipeline_keeper_;
  std::optional<PipelineMakers> pipeline_makers_{std::in_place};  // ends before the device does
};

}  // namespace fire3dv::gpu
