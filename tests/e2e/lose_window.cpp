// Stands before Vulkan's loader (LD_PRELOAD): the image of number LOSE_AT that is presented is not, since the
// display has taken the surface away (LOSE=surface), or the GPU is gone (LOSE=device). LOSE=memory: for the
// first buffer that is made when there is a file LOSE_AT, and that file goes.
#include <dlfcn.h>
#include <unistd.h>
#include <vulkan/vulkan.h>

#include <cstdlib>
#include <cstring>

extern "C" __attribute__((visibility("default"))) VKAPI_ATTR VkResult VKAPI_CALL
vkQueuePresentKHR(VkQueue queue, const VkPresentInfoKHR* info) {
  static const auto loaders =
      reinterpret_cast<PFN_vkQueuePresentKHR>(::dlsym(RTLD_NEXT, "vkQueuePresentKHR"));
  static int presented = 0;
  const VkResult result = loaders(queue, info);
  const char* const at = std::getenv("LOSE_AT");
  const char* const what = std::getenv("LOSE");
  if (!at || !what || std::strcmp(what, "memory") == 0 || ++presented != std::atoi(at)) return result;
  return std::strcmp(what, "surface") == 0 ? VK_ERROR_SURFACE_LOST_KHR : VK_ERROR_DEVICE_LOST;
}

extern "C" __attribute__((visibility("default"))) VKAPI_ATTR VkResult VKAPI_CALL
vkCreateBuffer(VkDevice device, const VkBufferCreateInfo* info, const VkAllocationCallbacks* callbacks,
               VkBuffer* buffer) {
  static const auto loaders = reinterpret_cast<PFN_vkCreateBuffer>(::dlsym(RTLD_NEXT, "vkCreateBuffer"));
  const char* const at = std::getenv("LOSE_AT");
  const char* const what = std::getenv("LOSE");
  if (at && what && std::strcmp(what, "memory") == 0 && ::unlink(at) == 0)
    return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  return loaders(device, info, callbacks, buffer);
}
