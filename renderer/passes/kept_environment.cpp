#include "renderer/passes/kept_environment.h"

#include <string>

#include "shaders/embedded.h"

namespace fire3dv::passes {

scene::Digest environment_kind(const VkPhysicalDeviceProperties& device, const scene::EnvironmentImage& image,
                               std::span<const uint32_t> recipe) {
  std::string text = std::string(device.deviceName) + '\0';
  for (const uint32_t number :
       {device.vendorID, device.deviceID, device.driverVersion, device.apiVersion, image.width, image.height})
    text += std::to_string(number) + '\0';
  text += scene::hex(device.pipelineCacheUUID) +
          scene::hex(scene::digest_of(std::as_bytes(std::span(image.rgb9e5))));
  for (const uint32_t number : recipe) text += '\0' + std::to_string(number);
  for (const std::string_view name : shaders::names()) {
    if (!name.starts_with("environment_")) continue;
    const std::span<const uint32_t> code = shaders::embedded(name);
    text += name;
    text.append(reinterpret_cast<const char*>(code.data()), code.size_bytes());
  }
  return scene::digest_of(std::as_bytes(std::span(text)));
}

}  // namespace fire3dv::passes
