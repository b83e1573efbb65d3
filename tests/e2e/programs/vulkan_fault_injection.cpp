// Fault injection for the Vulkan loader (LD_PRELOAD): lost surface, lost device, out of device memory.
// vkQueuePresentKHR number LOSE_AT returns VK_ERROR_SURFACE_LOST_KHR (LOSE=surface) or VK_ERROR_DEVICE_LOST
// (LOSE=device). LOSE=memory: while the file LOSE_AT exists, vkCreateBuffer fails for sizes in the range that
// the file contains: lowest bytes, highest bytes, number of failures (0: unlimited).
#include <dlfcn.h>
#include <unistd.h>
#include <vulkan/vulkan.h>

#include <cstdio>
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

static bool is_lost(unsigned long long bytes) {
  const char* const at = std::getenv("LOSE_AT");
  const char* const what = std::getenv("LOSE");
  if (!at || !what || std::strcmp(what, "memory") != 0) return false;
  std::FILE* const file = std::fopen(at, "r");
  if (!file) return false;
  unsigned long long low = 0, high = 0;
  int most = 0;
  const bool says = std::fscanf(file, "%llu %llu %d", &low, &high, &most) == 3;
  std::fclose(file);
  if (!says || bytes < low || bytes > high) return false;
  static int lost = 0;
  if (most != 0 && ++lost >= most) ::unlink(at);
  return true;
}

extern "C" __attribute__((visibility("default"))) VKAPI_ATTR VkResult VKAPI_CALL
vkCreateBuffer(VkDevice device, const VkBufferCreateInfo* info, const VkAllocationCallbacks* callbacks,
               VkBuffer* buffer) {
  static const auto loaders = reinterpret_cast<PFN_vkCreateBuffer>(::dlsym(RTLD_NEXT, "vkCreateBuffer"));
  if (is_lost(info->size)) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  return loaders(device, info, callbacks, buffer);
}
