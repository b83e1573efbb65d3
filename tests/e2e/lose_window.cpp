// Stands before Vulkan's loader (LD_PRELOAD): the image of number LOSE_AT that is presented is not, since the
// display has taken the surface away (LOSE=surface), or the GPU is gone (LOSE=device).
#include <dlfcn.h>
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
  if (!at || !what || ++presented != std::atoi(at)) return result;
  return std::strcmp(what, "surface") == 0 ? VK_ERROR_SURFACE_LOST_KHR : VK_ERROR_DEVICE_LOST;
}
