#include "renderer/gpu/loader/vulkan_loader.h"

#include <dlfcn.h>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "base/text.h"

// The loader's functions in use. A call of another one is an undefined reference for the linker: add it here.
// clang-format off
#define FIRE3DV_VULKAN_FUNCTIONS(X) \
  X(vkAcquireNextImageKHR) X(vkAllocateCommandBuffers) X(vkAllocateDescriptorSets) X(vkAllocateMemory) \
  X(vkBeginCommandBuffer) X(vkBindBufferMemory) X(vkBindBufferMemory2) X(vkBindImageMemory) \
  X(vkBindImageMemory2) X(vkCmdBeginRendering) X(vkCmdBindDescriptorSets) X(vkCmdBindIndexBuffer) \
  X(vkCmdBindPipeline) X(vkCmdBlitImage) X(vkCmdClearColorImage) X(vkCmdCopyBuffer) \
  X(vkCmdCopyBufferToImage) X(vkCmdCopyImage) X(vkCmdCopyImageToBuffer) X(vkCmdDispatch) \
  X(vkCmdDispatchIndirect) X(vkCmdDraw) X(vkCmdDrawIndexedIndirect) X(vkCmdDrawIndexedIndirectCount) \
  X(vkCmdEndRendering) X(vkCmdFillBuffer) X(vkCmdPipelineBarrier2) X(vkCmdPushConstants) \
  X(vkCmdSetCullMode) X(vkCmdSetFrontFace) X(vkCmdSetScissor) X(vkCmdSetViewport) X(vkCmdUpdateBuffer) \
  X(vkCmdWriteTimestamp2) X(vkCreateBuffer) X(vkCreateCommandPool) X(vkCreateComputePipelines) \
  X(vkCreateDescriptorPool) X(vkCreateDescriptorSetLayout) X(vkCreateDevice) X(vkCreateGraphicsPipelines) \
  X(vkCreateImage) X(vkCreateImageView) X(vkCreateInstance) X(vkCreatePipelineCache) \
  X(vkCreatePipelineLayout) X(vkCreateQueryPool) X(vkCreateSampler) X(vkCreateSemaphore) \
  X(vkCreateShaderModule) X(vkCreateSwapchainKHR) X(vkDestroyBuffer) X(vkDestroyCommandPool) \
  X(vkDestroyDescriptorPool) X(vkDestroyDescriptorSetLayout) X(vkDestroyDevice) X(vkDestroyImage) \
  X(vkDestroyImageView) X(vkDestroyInstance) X(vkDestroyPipeline) X(vkDestroyPipelineCache) \
  X(vkDestroyPipelineLayout) X(vkDestroyQueryPool) X(vkDestroySampler) X(vkDestroySemaphore) \
  X(vkDestroyShaderModule) X(vkDestroySurfaceKHR) X(vkDestroySwapchainKHR) X(vkEndCommandBuffer) \
  X(vkEnumerateDeviceExtensionProperties) X(vkEnumerateInstanceLayerProperties) \
  X(vkEnumerateInstanceVersion) X(vkEnumeratePhysicalDevices) X(vkFlushMappedMemoryRanges) X(vkFreeMemory) \
  X(vkGetBufferDeviceAddress) X(vkGetBufferMemoryRequirements) X(vkGetBufferMemoryRequirements2) \
  X(vkGetDeviceBufferMemoryRequirements) X(vkGetDeviceImageMemoryRequirements) X(vkGetDeviceProcAddr) \
  X(vkGetDeviceQueue) X(vkGetImageMemoryRequirements) X(vkGetImageMemoryRequirements2) \
  X(vkGetInstanceProcAddr) X(vkGetPhysicalDeviceFeatures2) X(vkGetPhysicalDeviceMemoryProperties) \
  X(vkGetPhysicalDeviceMemoryProperties2) X(vkGetPhysicalDeviceProperties) \
  X(vkGetPhysicalDeviceProperties2) X(vkGetPhysicalDeviceQueueFamilyProperties) \
  X(vkGetPhysicalDeviceSurfaceCapabilitiesKHR) X(vkGetPhysicalDeviceSurfaceFormatsKHR) \
  X(vkGetPhysicalDeviceSurfacePresentModesKHR) X(vkGetPhysicalDeviceSurfaceSupportKHR) \
  X(vkGetPipelineCacheData) X(vkGetQueryPoolResults) X(vkGetSemaphoreCounterValue) \
  X(vkGetSwapchainImagesKHR) X(vkInvalidateMappedMemoryRanges) X(vkMapMemory) X(vkQueuePresentKHR) \
  X(vkQueueSubmit2) X(vkQueueWaitIdle) X(vkResetCommandPool) X(vkResetQueryPool) X(vkUnmapMemory) \
  X(vkUpdateDescriptorSets) X(vkWaitSemaphores)
// clang-format on

// Each function is a jump to the loaded one: callers use Vulkan's own prototypes and addresses.
#if defined(__x86_64__)
#define FIRE3DV_JUMP(name) "endbr64\njmp *fire3dv_loaded_" #name "(%rip)\n"
#elif defined(__aarch64__)
#define FIRE3DV_JUMP(name)                                                                   \
  "hint #34\nadrp x16, fire3dv_loaded_" #name "\nldr x16, [x16, :lo12:fire3dv_loaded_" #name \
  "]\n"                                                                                      \
  "br x16\n"
#else
#error "write the jump of this processor"
#endif
#define FIRE3DV_DEFINE(name)                                                                        \
  extern "C" {                                                                                      \
  [[gnu::visibility("hidden"), gnu::used]] void* fire3dv_loaded_##name = nullptr;                   \
  }                                                                                                 \
  asm(".pushsection .text\n.globl " #name "\n.hidden " #name "\n.type " #name ", %function\n" #name \
      ":\n" FIRE3DV_JUMP(name) ".size " #name ", .-" #name "\n.popsection");
FIRE3DV_VULKAN_FUNCTIONS(FIRE3DV_DEFINE)

namespace fire3dv::gpu {
namespace {

constexpr const char* kLibrary = "libvulkan.so.1";

// A pipe or device in the place of the library, which dlopen() would wait for. LD_LIBRARY_PATH comes first.
std::string find_unreadable(std::string_view folders) {
  for (size_t begin = 0; begin <= folders.size();) {
    const size_t end = std::min(folders.find_first_of(":;", begin), folders.size());
    const std::filesystem::path file = std::filesystem::path(folders.substr(begin, end - begin)) / kLibrary;
    std::error_code ignored;
    const std::filesystem::file_status status = std::filesystem::status(file, ignored);
    if (std::filesystem::is_regular_file(status)) return "";
    if (std::filesystem::exists(status)) return file.string();
    begin = end + 1;
  }
  return "";
}

VulkanLoader load() {
  VulkanLoader loader;
  if (const char* const folders = std::getenv("LD_LIBRARY_PATH")) {
    if (const std::string file = find_unreadable(folders); !file.empty()) {
      loader.fault = printable_text(file, 300) + " is no file";
      return loader;
    }
  }
  // Global, and looked up there: preloaded libraries may stand in for functions.
  if (!::dlopen(kLibrary, RTLD_NOW | RTLD_GLOBAL)) {
    loader.fault = ::dlerror();
    return loader;
  }
  const auto find = [&](const char* name, void*& function) {
    function = ::dlsym(RTLD_DEFAULT, name);
    if (!function && loader.fault.empty())
      loader.fault = std::string(kLibrary) + " is too old: it lacks " + name;
  };
#define FIRE3DV_FIND(name) find(#name, fire3dv_loaded_##name);
  FIRE3DV_VULKAN_FUNCTIONS(FIRE3DV_FIND)
  Dl_info info{};
  if (::dladdr(fire3dv_loaded_vkCreateInstance, &info) && info.dli_fname) loader.file = info.dli_fname;
  return loader;
}

}  // namespace

const VulkanLoader& vulkan_loader() {
  static const VulkanLoader loaded = load();
  return loaded;
}

}  // namespace fire3dv::gpu
