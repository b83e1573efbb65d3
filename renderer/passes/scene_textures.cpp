#include "renderer/passes/scene_textures.h"

#include <algorithm>
#include <bit>
#include <map>

namespace fire3dv::passes {
namespace {

VkSamplerAddressMode address_mode(scene::Wrap wrap) {
  switch (wrap) {
    case scene::Wrap::repeat:
      return VK_SAMPLER_ADDRESS_MODE_REPEAT;
    case scene::Wrap::mirrored_repeat:
      return VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT;
    case scene::Wrap::clamp_to_edge:
      return VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  }
  return VK_SAMPLER_ADDRESS_MODE_REPEAT;
}

gpu::Sampler create_sampler(gpu::Device& device, const scene::Sampler& wanted, float anisotropy) {
  VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  info.magFilter = wanted.nearest_mag ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
  info.minFilter = wanted.nearest_min ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
  info.mipmapMode = wanted.nearest_mip ? VK_SAMPLER_MIPMAP_MODE_NEAREST : VK_SAMPLER_MIPMAP_MODE_LINEAR;
  info.addressModeU = address_mode(wanted.wrap_u);
  info.addressModeV = address_mode(wanted.wrap_v);
  info.addressModeW = VK_SAMPLER_ADDRESS_MODE_REPEAT;
  info.maxLod = wanted.use_mips ? VK_LOD_CLAMP_NONE : 0.25f;
  const bool smooth = !wanted.nearest_mag && !wanted.nearest_min && wanted.use_mips;
  if (smooth && anisotropy > 1 && device.report().anisotropy) {
    info.anisotropyEnable = VK_TRUE;
    info.maxAnisotropy = std::min(anisotropy, device.limits().maxSamplerAnisotropy);
  }
  VkSampler sampler = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateSampler(device.handle(), &info, nullptr, &sampler));
  return gpu::Sampler(device, sampler);
}

}  // namespace

SceneTextures upload_textures(gpu::Device& device, gpu::LoaderCommands& loader, const scene::Scene& scene,
                              float anisotropy) {
  std::map<std::pair<uint32_t, bool>, VkImageView> views;
  std::vector<std::pair<scene::Sampler, VkSampler>> samplers;
  SceneTextures uploaded;
  for (const scene::Texture& texture : scene.textures) {
    VkImageView& view = views[{texture.image, texture.srgb}];
    if (!view) {
      const scene::Image& source = scene.images[texture.image];
      gpu::ImageInfo info;
      info.format = texture.srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM;
      info.extent = {source.width, source.height};
      info.mip_levels = static_cast<uint32_t>(std::bit_width(std::max(source.width, source.height)));
      info.usage =
          VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
      gpu::Image& image = uploaded.images.emplace_back(gpu::create_image(device, info));
      loader.upload_rgba8(image, source.rgba8);
      view = image.view.get();
    }
    auto sampler = std::find_if(samplers.begin(), samplers.end(),
                                [&](const auto& known) { return known.first == texture.sampler; });
    if (sampler == samplers.end()) {
      uploaded.samplers.push_back(create_sampler(device, texture.sampler, anisotropy));
      samplers.emplace_back(texture.sampler, uploaded.samplers.back().get());
      sampler = samplers.end() - 1;
    }
    uploaded.sampled.push_back({view, sampler->second});
  }
  return uploaded;
}

}  // namespace fire3dv::passes
