#include "renderer/passes/environment/prepared_environment.h"

#include <string>

#include "renderer/passes/resources/device_kind.h"

namespace fire3dv::passes {

Digest environment_kind(const VkPhysicalDeviceProperties& device, const scene::EnvironmentImage& image,
                        std::span<const uint32_t> recipe) {
  std::string text =
      hex(device_kind(device, "environment_")) + hex(digest_of(std::as_bytes(std::span(image.rgb9e5))));
  for (const uint32_t number : {image.width, image.height}) text += '\0' + std::to_string(number);
  for (const uint32_t number : recipe) text += '\0' + std::to_string(number);
  return digest_of(std::as_bytes(std::span(text)));
}

}  // namespace fire3dv::passes
