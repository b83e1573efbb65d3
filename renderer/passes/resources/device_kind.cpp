#include "renderer/passes/resources/device_kind.h"

#include <span>
#include <string>

#include "shaders/embedded.h"

namespace fire3dv::passes {

Digest device_kind(const VkPhysicalDeviceProperties& device, std::string_view beginning) {
  std::string text = std::string(device.deviceName) + '\0';
  for (const uint32_t number : {device.vendorID, device.deviceID, device.driverVersion, device.apiVersion})
    text += std::to_string(number) + '\0';
  text += hex(device.pipelineCacheUUID);
  for (const std::string_view name : shaders::names()) {
    if (!name.starts_with(beginning)) continue;
    const std::span<const uint32_t> code = shaders::embedded(name);
    text += name;
    text.append(reinterpret_cast<const char*>(code.data()), code.size_bytes());
  }
  return digest_of(std::as_bytes(std::span(text)));
}

}  // namespace fire3dv::passes
