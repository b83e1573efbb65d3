// Move-only owner of a Vulkan object. The destructor retires the object instead of destroying it; Device
// destroys it once the timeline has passed the frames that may use it. No thread waits for the GPU.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "renderer/gpu/device/vk.h"

struct VmaAllocation_T;

namespace fire3dv::gpu {

class Device;

enum class ObjectKind : uint8_t {
  buffer,
  image,
  image_view,
  sampler,
  shader_module,
  pipeline,
  pipeline_layout,
  set_layout,
  descriptor_pool,
  query_pool,
  command_pool,
  semaphore,
  acceleration_structure,
  swapchain,
};
constexpr size_t kObjectKinds = static_cast<size_t>(ObjectKind::swapchain) + 1;
const char* object_kind_name(ObjectKind kind);

// Live objects by kind, including retired objects until they are freed. The leak test reads these counts.
using LiveObjects = std::array<int64_t, kObjectKinds>;

namespace detail {
void retire(Device& device, ObjectKind kind, uint64_t object, VmaAllocation_T* allocation);
void count_created(Device& device, ObjectKind kind);
}  // namespace detail

template <ObjectKind kind, typename VkHandle>
class Handle {
 public:
  Handle() = default;
  Handle(Device& device, VkHandle object, VmaAllocation_T* allocation = nullptr)
      : device_(&device), object_(object), allocation_(allocation) {
    detail::count_created(device, kind);
  }
  Handle(Handle&& other) noexcept
      : device_(other.device_),
        object_(std::exchange(other.object_, VkHandle{})),
        allocation_(std::exchange(other.allocation_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) {
      reset();
      device_ = other.device_;
      object_ = std::exchange(other.object_, VkHandle{});
      allocation_ = std::exchange(other.allocation_, nullptr);
    }
    return *this;
  }
  ~Handle() { reset(); }

  void reset() {
    if (object_) detail::retire(*device_, kind, reinterpret_cast<uint64_t>(object_), allocation_);
    object_ = VkHandle{};
    allocation_ = nullptr;
  }
  VkHandle get() const { return object_; }
  explicit operator bool() const { return object_ != VkHandle{}; }
  VmaAllocation_T* allocation() const { return allocation_; }
  Device& device() const { return *device_; }

 private:
  Device* device_ = nullptr;
  VkHandle object_{};
  VmaAllocation_T* allocation_ = nullptr;
};

using BufferHandle = Handle<ObjectKind::buffer, VkBuffer>;
using ImageHandle = Handle<ObjectKind::image, VkImage>;
using ImageView = Handle<ObjectKind::image_view, VkImageView>;
using Sampler = Handle<ObjectKind::sampler, VkSampler>;
using ShaderModule = Handle<ObjectKind::shader_module, VkShaderModule>;
using PipelineHandle = Handle<ObjectKind::pipeline, VkPipeline>;
using PipelineLayout = Handle<ObjectKind::pipeline_layout, VkPipelineLayout>;
using SetLayout = Handle<ObjectKind::set_layout, VkDescriptorSetLayout>;
using DescriptorPool = Handle<ObjectKind::descriptor_pool, VkDescriptorPool>;
using QueryPool = Handle<ObjectKind::query_pool, VkQueryPool>;
using CommandPool = Handle<ObjectKind::command_pool, VkCommandPool>;
using Semaphore = Handle<ObjectKind::semaphore, VkSemaphore>;
using AccelerationHandle = Handle<ObjectKind::acceleration_structure, VkAccelerationStructureKHR>;
using SwapchainHandle = Handle<ObjectKind::swapchain, VkSwapchainKHR>;

}  // namespace fire3dv::gpu
