/* Vulkan driver of the doctor's tests: one device that draws nothing but a cleared image, and breaks as the
 * environment variable FIRE3DV_FAKE_DRIVER says:
 *   crash_on_load, no_instance, hang_in_listing, crash_in_listing, hang_in_wait, wrong_pixels, crash_in_rays,
 *   old_mesa.
 * Without it the device works. */
#define _GNU_SOURCE
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <vulkan/vulkan.h>

#define EXPORT __attribute__((visibility("default")))
#define HANDLE(pointer) ((uint64_t)(uintptr_t)(pointer))

static int is_broken(const char* way) {
  const char* const chosen = getenv("FIRE3DV_FAKE_DRIVER");
  return chosen && strcmp(chosen, way) == 0;
}
static void crash(void) {
  raise(SIGKILL);
} /* no handler of a sanitizer takes it */
static void hang(void) {
  for (;;) pause();
}

__attribute__((constructor)) static void on_load(void) {
  if (is_broken("crash_on_load")) crash();
}

/* The loader writes its dispatch table to the first word. */
typedef struct {
  uint64_t loader_magic;
} Dispatchable;
static Dispatchable* new_dispatchable(void) {
  Dispatchable* const object = calloc(1, 64);
  object->loader_magic = 0x01CDC0DE;
  return object;
}

typedef struct {
  VkDeviceSize bytes;
  unsigned char* memory;
  uint64_t counter; /* of a timeline semaphore */
} Object;

static VkResult new_object(uint64_t* out, VkDeviceSize bytes) {
  Object* const object = calloc(1, sizeof(Object));
  object->bytes = bytes;
  *out = HANDLE(object);
  return VK_SUCCESS;
}
static Object* object_of(uint64_t handle) {
  return (Object*)(uintptr_t)handle;
}

/* --- instance --- */

static VkResult create_instance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocator,
                                VkInstance* out) {
  (void)info, (void)allocator;
  *out = (VkInstance)new_dispatchable();
  return VK_SUCCESS;
}
static VkResult instance_version(uint32_t* version) {
  *version = VK_API_VERSION_1_3;
  return VK_SUCCESS;
}
static VkResult no_instance_extensions(const char* layer, uint32_t* count, VkExtensionProperties* out) {
  (void)layer, (void)out;
  *count = 0;
  return VK_SUCCESS;
}
static VkResult list_devices(VkInstance instance, uint32_t* count, VkPhysicalDevice* out) {
  static Dispatchable* device;
  (void)instance;
  if (is_broken("hang_in_listing")) hang();
  if (is_broken("crash_in_listing")) crash();
  if (!device) device = new_dispatchable();
  if (out && *count) *out = (VkPhysicalDevice)device;
  *count = 1;
  return VK_SUCCESS;
}

/* --- device properties --- */

static const char* const kRayExtensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                             VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                             VK_KHR_RAY_QUERY_EXTENSION_NAME};

static VkResult device_extensions(VkPhysicalDevice device, const char* layer, uint32_t* count,
                                  VkExtensionProperties* out) {
  const uint32_t total = is_broken("crash_in_rays") ? 3 : 0;
  (void)device, (void)layer;
  if (out) {
    if (*count > total) *count = total;
    memset(out, 0, *count * sizeof *out);
    for (uint32_t i = 0; i < *count; ++i) strcpy(out[i].extensionName, kRayExtensions[i]);
  } else {
    *count = total;
  }
  return VK_SUCCESS;
}

static void properties(VkPhysicalDevice device, VkPhysicalDeviceProperties* out) {
  (void)device;
  memset(out, 0, sizeof *out);
  out->apiVersion = VK_API_VERSION_1_3;
  out->vendorID = 0xfade;
  out->deviceType =
      is_broken("old_mesa") ? VK_PHYSICAL_DEVICE_TYPE_CPU : VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
  strcpy(out->deviceName, "fake GPU");
  VkPhysicalDeviceLimits* const limits = &out->limits;
  limits->maxImageDimension2D = 16384;
  limits->maxComputeWorkGroupInvocations = limits->maxComputeWorkGroupSize[0] = 1024;
  limits->maxMemoryAllocationCount = 4096;
  limits->framebufferColorSampleCounts = limits->framebufferDepthSampleCounts = 5;
  limits->bufferImageGranularity = limits->nonCoherentAtomSize = 64;
  limits->timestampPeriod = 1;
}

static void properties2(VkPhysicalDevice device, VkPhysicalDeviceProperties2* out) {
  properties(device, &out->properties);
  for (VkBaseOutStructure* next = out->pNext; next; next = next->pNext) {
    if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES) {
      VkPhysicalDeviceDriverProperties* const driver = (VkPhysicalDeviceDriverProperties*)next;
      strcpy(driver->driverName, is_broken("old_mesa") ? "llvmpipe" : "fake");
      strcpy(driver->driverInfo, is_broken("old_mesa") ? "Mesa 22.3.6 (LLVM 15.0.6)" : "1.0");
    } else if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES) {
      VkPhysicalDeviceVulkan11Properties* const subgroups = (VkPhysicalDeviceVulkan11Properties*)next;
      subgroups->subgroupSize = 32;
      subgroups->subgroupSupportedStages = VK_SHADER_STAGE_ALL;
      subgroups->subgroupSupportedOperations = ~0u;
    } else if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES) {
      VkPhysicalDeviceSubgroupProperties* const subgroups = (VkPhysicalDeviceSubgroupProperties*)next;
      subgroups->subgroupSize = 32;
      subgroups->supportedStages = VK_SHADER_STAGE_ALL;
      subgroups->supportedOperations = ~0u;
    } else if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES) {
      memset(((VkPhysicalDeviceIDProperties*)next)->deviceUUID, 0xfa, VK_UUID_SIZE);
    } else if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR) {
      ((VkPhysicalDeviceAccelerationStructurePropertiesKHR*)next)
          ->minAccelerationStructureScratchOffsetAlignment = 64;
    }
  }
}

static void set_all(void* first, void* end) {
  for (VkBool32* feature = first; (void*)feature < end; ++feature) *feature = VK_TRUE;
}
#define SET_FEATURES(type, first)                     \
  do {                                                \
    type* const features = (type*)next;               \
    set_all(&features->first, (char*)(features + 1)); \
  } while (0)

static void features2(VkPhysicalDevice device, VkPhysicalDeviceFeatures2* out) {
  (void)device;
  set_all(&out->features, &out->features + 1);
  for (VkBaseOutStructure* next = out->pNext; next; next = next->pNext) {
    switch ((int)next->sType) {
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES:
        SET_FEATURES(VkPhysicalDeviceVulkan11Features, storageBuffer16BitAccess);
        break;
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES:
        SET_FEATURES(VkPhysicalDeviceVulkan12Features, samplerMirrorClampToEdge);
        if (is_broken("old_mesa"))
          ((VkPhysicalDeviceVulkan12Features*)next)->runtimeDescriptorArray = VK_FALSE;
        break;
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES:
        SET_FEATURES(VkPhysicalDeviceVulkan13Features, robustImageAccess);
        break;
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR:
        SET_FEATURES(VkPhysicalDeviceAccelerationStructureFeaturesKHR, accelerationStructure);
        break;
      case VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR:
        SET_FEATURES(VkPhysicalDeviceRayQueryFeaturesKHR, rayQuery);
        break;
    }
  }
}

static void queue_families(VkPhysicalDevice device, uint32_t* count, VkQueueFamilyProperties* out) {
  (void)device;
  if (out && *count) {
    memset(out, 0, sizeof *out);
    out->queueFlags = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT;
    out->queueCount = 1;
    out->timestampValidBits = 64;
  }
  *count = 1;
}

static void memory_properties(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties* out) {
  (void)device;
  memset(out, 0, sizeof *out);
  out->memoryTypeCount = out->memoryHeapCount = 1;
  out->memoryTypes[0].propertyFlags =
      VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
      VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  out->memoryHeaps[0].size = (VkDeviceSize)1 << 30;
  out->memoryHeaps[0].flags = VK_MEMORY_HEAP_DEVICE_LOCAL_BIT;
}
static void memory_properties2(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties2* out) {
  memory_properties(device, &out->memoryProperties);
}

/* --- device --- */

static VkResult create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                              const VkAllocationCallbacks* allocator, VkDevice* out) {
  (void)physical, (void)info, (void)allocator;
  *out = (VkDevice)new_dispatchable();
  return VK_SUCCESS;
}
static void get_queue(VkDevice device, uint32_t family, uint32_t index, VkQueue* out) {
  static Dispatchable* queue;
  (void)device, (void)family, (void)index;
  if (!queue) queue = new_dispatchable();
  *out = (VkQueue)queue;
}
static VkResult allocate_commands(VkDevice device, const VkCommandBufferAllocateInfo* info,
                                  VkCommandBuffer* out) {
  (void)device;
  for (uint32_t i = 0; i < info->commandBufferCount; ++i) out[i] = (VkCommandBuffer)new_dispatchable();
  return VK_SUCCESS;
}
static VkResult create_buffer(VkDevice device, const VkBufferCreateInfo* info,
                              const VkAllocationCallbacks* allocator, uint64_t* out) {
  (void)device, (void)allocator;
  return new_object(out, (info->size + 255) / 256 * 256);
}
static VkResult create_image(VkDevice device, const VkImageCreateInfo* info,
                             const VkAllocationCallbacks* allocator, uint64_t* out) {
  (void)device, (void)allocator;
  return new_object(out, (VkDeviceSize)16 * info->extent.width * info->extent.height);
}
static VkResult create_any(VkDevice device, const void* info, const VkAllocationCallbacks* allocator,
                           uint64_t* out) {
  (void)device, (void)info, (void)allocator;
  return new_object(out, 0);
}
static VkResult create_pipelines(VkDevice device, uint64_t cache, uint32_t count, const void* infos,
                                 const VkAllocationCallbacks* allocator, uint64_t* out) {
  (void)device, (void)cache, (void)infos, (void)allocator;
  for (uint32_t i = 0; i < count; ++i) new_object(&out[i], 0);
  return VK_SUCCESS;
}
static void requirements(VkDevice device, uint64_t object, VkMemoryRequirements* out) {
  (void)device;
  out->size = object_of(object)->bytes;
  out->alignment = 256;
  out->memoryTypeBits = 1;
}
static void buffer_requirements2(VkDevice device, const VkBufferMemoryRequirementsInfo2* info,
                                 VkMemoryRequirements2* out) {
  requirements(device, HANDLE(info->buffer), &out->memoryRequirements);
}
static void image_requirements2(VkDevice device, const VkImageMemoryRequirementsInfo2* info,
                                VkMemoryRequirements2* out) {
  requirements(device, HANDLE(info->image), &out->memoryRequirements);
}
static VkResult allocate_memory(VkDevice device, const VkMemoryAllocateInfo* info,
                                const VkAllocationCallbacks* allocator, uint64_t* out) {
  (void)device, (void)allocator;
  new_object(out, info->allocationSize);
  object_of(*out)->memory = calloc(1, info->allocationSize);
  return VK_SUCCESS;
}
static VkResult map_memory(VkDevice device, uint64_t memory, VkDeviceSize offset, VkDeviceSize size,
                           VkMemoryMapFlags flags, void** out) {
  (void)device, (void)size, (void)flags;
  *out = object_of(memory)->memory + offset;
  return VK_SUCCESS;
}
static VkResult bind_buffer(VkDevice device, uint64_t buffer, uint64_t memory, VkDeviceSize offset) {
  (void)device;
  object_of(buffer)->memory = object_of(memory)->memory + offset;
  return VK_SUCCESS;
}
static VkResult bind_buffers2(VkDevice device, uint32_t count, const VkBindBufferMemoryInfo* infos) {
  for (uint32_t i = 0; i < count; ++i)
    bind_buffer(device, HANDLE(infos[i].buffer), HANDLE(infos[i].memory), infos[i].memoryOffset);
  return VK_SUCCESS;
}
static uint64_t address(void) {
  return 0x10000;
}

/* --- commands: a clear, and its copy to a buffer, run when they are recorded --- */

static VkClearColorValue cleared;
static void clear_image(VkCommandBuffer commands, uint64_t image, VkImageLayout layout,
                        const VkClearColorValue* value, uint32_t count,
                        const VkImageSubresourceRange* ranges) {
  (void)commands, (void)image, (void)layout, (void)count, (void)ranges;
  cleared = *value;
}
static void copy_image(VkCommandBuffer commands, uint64_t image, VkImageLayout layout, uint64_t buffer,
                       uint32_t count, const VkBufferImageCopy* copies) {
  (void)commands, (void)image, (void)layout, (void)count;
  unsigned char* const pixels = object_of(buffer)->memory + copies->bufferOffset;
  const size_t bytes = (size_t)4 * copies->imageExtent.width * copies->imageExtent.height;
  if (is_broken("wrong_pixels")) return;
  for (size_t i = 0; i < bytes; ++i) pixels[i] = (unsigned char)(255 * cleared.float32[i % 4]);
}
static void build_sizes(VkDevice device, int type, const void* info, const uint32_t* counts,
                        VkAccelerationStructureBuildSizesInfoKHR* out) {
  (void)device, (void)type, (void)info, (void)counts;
  out->accelerationStructureSize = out->buildScratchSize = out->updateScratchSize = 1024;
}

static VkResult submit(VkQueue queue, uint32_t count, const VkSubmitInfo2* submits, uint64_t fence) {
  (void)queue, (void)fence;
  for (uint32_t i = 0; i < count && !is_broken("hang_in_wait"); ++i) {
    for (uint32_t j = 0; j < submits[i].signalSemaphoreInfoCount; ++j) {
      const VkSemaphoreSubmitInfo* const signal = &submits[i].pSignalSemaphoreInfos[j];
      object_of(HANDLE(signal->semaphore))->counter = signal->value;
    }
  }
  return VK_SUCCESS;
}
static VkResult wait_semaphores(VkDevice device, const VkSemaphoreWaitInfo* info, uint64_t timeout) {
  (void)device, (void)info, (void)timeout;
  if (is_broken("hang_in_wait")) hang();
  return VK_SUCCESS;
}
static VkResult semaphore_counter(VkDevice device, uint64_t semaphore, uint64_t* out) {
  (void)device;
  *out = object_of(semaphore)->counter;
  return VK_SUCCESS;
}

static uint64_t succeed(void) {
  return 0;
}

static PFN_vkVoidFunction find(const char* name) {
  static const struct {
    const char* name;
    void* function;
  } kFunctions[] = {
      {"vkCreateInstance", create_instance},
      {"vkEnumerateInstanceVersion", instance_version},
      {"vkEnumerateInstanceExtensionProperties", no_instance_extensions},
      {"vkEnumeratePhysicalDevices", list_devices},
      {"vkEnumerateDeviceExtensionProperties", device_extensions},
      {"vkGetPhysicalDeviceProperties", properties},
      {"vkGetPhysicalDeviceProperties2", properties2},
      {"vkGetPhysicalDeviceFeatures2", features2},
      {"vkGetPhysicalDeviceQueueFamilyProperties", queue_families},
      {"vkGetPhysicalDeviceMemoryProperties", memory_properties},
      {"vkGetPhysicalDeviceMemoryProperties2", memory_properties2},
      {"vkCreateDevice", create_device},
      {"vkGetDeviceQueue", get_queue},
      {"vkAllocateCommandBuffers", allocate_commands},
      {"vkCreateBuffer", create_buffer},
      {"vkCreateImage", create_image},
      {"vkCreateComputePipelines", create_pipelines},
      {"vkGetBufferMemoryRequirements", requirements},
      {"vkGetImageMemoryRequirements", requirements},
      {"vkGetBufferMemoryRequirements2", buffer_requirements2},
      {"vkGetImageMemoryRequirements2", image_requirements2},
      {"vkAllocateMemory", allocate_memory},
      {"vkMapMemory", map_memory},
      {"vkBindBufferMemory", bind_buffer},
      {"vkBindBufferMemory2", bind_buffers2},
      {"vkGetBufferDeviceAddress", address},
      {"vkGetAccelerationStructureDeviceAddressKHR", address},
      {"vkGetAccelerationStructureBuildSizesKHR", build_sizes},
      {"vkCmdBuildAccelerationStructuresKHR", crash},
      {"vkCmdClearColorImage", clear_image},
      {"vkCmdCopyImageToBuffer", copy_image},
      {"vkQueueSubmit2", submit},
      {"vkWaitSemaphores", wait_semaphores},
      {"vkGetSemaphoreCounterValue", semaphore_counter},
  };
  for (size_t i = 0; i < sizeof kFunctions / sizeof *kFunctions; ++i)
    if (strcmp(kFunctions[i].name, name) == 0) return (PFN_vkVoidFunction)(uintptr_t)kFunctions[i].function;
  if (strncmp(name, "vkCreate", 8) == 0) return (PFN_vkVoidFunction)create_any;
  return strncmp(name, "vk", 2) == 0 ? (PFN_vkVoidFunction)succeed : NULL;
}

EXPORT PFN_vkVoidFunction vk_icdGetInstanceProcAddr(VkInstance instance, const char* name);
static PFN_vkVoidFunction device_function(VkDevice device, const char* name) {
  (void)device;
  return find(name);
}
PFN_vkVoidFunction vk_icdGetInstanceProcAddr(VkInstance instance, const char* name) {
  (void)instance;
  if (is_broken("no_instance") && strcmp(name, "vkCreateInstance") == 0) return NULL;
  if (strcmp(name, "vkGetDeviceProcAddr") == 0) return (PFN_vkVoidFunction)device_function;
  if (strstr(name, "Surface") || strstr(name, "Swapchain") || strstr(name, "Display")) return NULL;
  return find(name);
}
EXPORT VkResult vk_icdNegotiateLoaderICDInterfaceVersion(uint32_t* version);
VkResult vk_icdNegotiateLoaderICDInterfaceVersion(uint32_t* version) {
  if (*version > 5) *version = 5;
  return VK_SUCCESS;
}
