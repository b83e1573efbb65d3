#include "renderer/passes/resources/scene_textures.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <span>

#include "renderer/scene/textures/mip_generator.h"

namespace fire3dv::passes {
namespace {

constexpr size_t kChunkBytes = size_t{16} << 20;

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

VkSampler TextureUploads::sampler_of(const scene::Sampler& wanted) {
  const auto known = std::find_if(samplers_.begin(), samplers_.end(),
                                  [&](const auto& sampler) { return sampler.first == wanted; });
  if (known != samplers_.end()) return known->second;
  uploaded_.samplers.push_back(create_sampler(device_, wanted, anisotropy_));
  return samplers_.emplace_back(wanted, uploaded_.samplers.back().get()).second;
}

TextureUploads::TextureUploads(gpu::Device& device, const scene::Scene& scene, float anisotropy,
                               const SceneTextures* before)
    : device_(device), scene_(scene), anisotropy_(anisotropy), loader_(device) {
  if (!before) return;
  for (const SharedTexture& texture : before->images) {
    // Pixels that are gone may have left their address to others.
    if (const std::shared_ptr<const void> pixels = texture.pixels.lock())
      known_[{pixels.get(), texture.srgb}] = texture.image;
  }
}

void TextureUploads::add(const scene::Texture& texture) {
  VkImageView& view = views_[{texture.image, texture.srgb}];
  if (!view) {
    const scene::Image& source = scene_.images[texture.image];
    const std::shared_ptr<const void> pixels = source.rgba8.identity();
    const auto known = known_.find({pixels.get(), texture.srgb});
    const std::shared_ptr<gpu::Image> image =
        pixels && known != known_.end() ? known->second : upload(source, texture.srgb);
    if (pixels) known_[{pixels.get(), texture.srgb}] = image;  // several images may share their pixels
    uploaded_.images.push_back({pixels, texture.srgb, image});
    view = image->view.get();
  }
  uploaded_.sampled.push_back({view, sampler_of(texture.sampler)});
}

std::shared_ptr<gpu::Image> TextureUploads::upload(const scene::Image& source, bool srgb) {
  gpu::ImageInfo info;
  info.format = srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM;
  info.extent = {source.width, source.height};
  info.mip_levels = static_cast<uint32_t>(std::bit_width(std::max(source.width, source.height)));
  info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  auto image = std::make_shared<gpu::Image>(gpu::create_image(device_, info));
  const std::vector<std::vector<uint8_t>> smaller = scene::generate_mip_levels(source, srgb);
  std::vector<std::span<const std::byte>> levels{std::as_bytes(std::span(source.rgba8))};
  for (const std::vector<uint8_t>& level : smaller) levels.push_back(std::as_bytes(std::span(level)));
  loader_.upload_levels(*image, levels);
  chunk_bytes_ += source.rgba8.size();
  return image;
}

void TextureUploads::submit_some() {
  chunk_bytes_ = 0;
  while (next_ < scene_.textures.size() && chunk_bytes_ < kChunkBytes) add(scene_.textures[next_++]);
  loader_.submit();
}

SceneTextures TextureUploads::finish() {
  while (next_ < scene_.textures.size()) submit_some();
  loader_.finish();
  return std::move(uploaded_);
}

}  // namespace fire3dv::passes
