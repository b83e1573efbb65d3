#include "renderer/passes/texture_capacity.h"

#include <string>

#include "renderer/gpu/device/device.h"
#include "renderer/gpu/pipelines/descriptors.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::passes {

Result<void> check_texture_count(const gpu::Device& device, const scene::Scene& scene) {
  const uint32_t max_textures = gpu::BindlessTextures::most(device);
  if (scene.textures.size() <= max_textures) return {};
  return Error{scene.source.string() + " has " + std::to_string(scene.textures.size()) + " textures, but " +
               device.report().name + " takes " + std::to_string(max_textures) +
               " at most: split the file, or choose another device with --device"};
}

Result<void> ensure_texture_capacity(gpu::Device& device, settings::DrawSettings settings,
                                     const scene::Scene& scene, std::optional<SceneRenderer>& renderer) {
  if (scene.textures.size() <= settings.max_textures) return {};
  if (Result<void> can = check_texture_count(device, scene); !can) return can;
  settings.max_textures = static_cast<uint32_t>(scene.textures.size());
  renderer.reset();
  renderer.emplace(device, settings);
  return {};
}

}  // namespace fire3dv::passes
