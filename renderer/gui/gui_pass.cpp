#include "renderer/gui/gui_pass.h"

#include <imgui.h>

#include <algorithm>
#include <array>

#include "shaders/shared/bindings.h"

namespace fire3dv::gui {

using gpu::Use;
namespace access = gpu::access;

GuiPass::GuiPass(gpu::Device& device) : device_(device) {
  const VkDescriptorSetLayoutBinding bindings[] = {
      {FIRE3DV_BINDING_FILTER_IN, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_COMPUTE_BIT,
       nullptr},
      {FIRE3DV_BINDING_FILTER_OUT, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
  };
  set_layout_ = gpu::create_set_layout(device, bindings);
  layout_ = gpu::create_pipeline_layout(device, std::array{set_layout_.get()});
  pipeline_ = gpu::create_compute_pipeline(device, layout_.get(), "gui.comp");

  VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  info.magFilter = info.minFilter = VK_FILTER_LINEAR;  // glyph edges lie between texels
  info.addressModeU = info.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  VkSampler sampler = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateSampler(device.handle(), &info, nullptr, &sampler));
  sampler_ = gpu::Sampler(device, sampler);
}

void GuiPass::upload_fonts(gpu::Recorder& recorder, gpu::StagingRing& staging, const ImFontAtlas& fonts) {
  const VkExtent2D extent{static_cast<uint32_t>(fonts.TexWidth), static_cast<uint32_t>(fonts.TexHeight)};
  FIRE3DV_ASSERT(fonts.TexPixelsAlpha8);
  fonts_ = gpu::create_image(
      device_, {VK_FORMAT_R8_UNORM, extent, VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
  const gpu::StagingRing::Piece piece =
      staging.write(std::span<const uint8_t>(fonts.TexPixelsAlpha8, size_t{extent.width} * extent.height));
  recorder.pass("gui", {Use(fonts_, access::transfer_write, true)}, [&](VkCommandBuffer commands) {
    VkBufferImageCopy copy{};
    copy.bufferOffset = piece.offset;
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.imageExtent = {extent.width, extent.height, 1};
    vkCmdCopyBufferToImage(commands, piece.buffer, fonts_.get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                           &copy);
  });
}

void GuiPass::bind(const gpu::Image& image) {
  const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1},
                                        {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 1}};
  set_ = gpu::DescriptorSet(device_, set_layout_.get(), sizes);
  const VkDescriptorImageInfo in{sampler_.get(), fonts_.view.get(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  const VkDescriptorImageInfo out{VK_NULL_HANDLE, image.view.get(), VK_IMAGE_LAYOUT_GENERAL};
  VkWriteDescriptorSet writes[2] = {{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET},
                                    {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET}};
  writes[0].dstSet = writes[1].dstSet = set_.get();
  writes[0].dstBinding = FIRE3DV_BINDING_FILTER_IN;
  writes[1].dstBinding = FIRE3DV_BINDING_FILTER_OUT;
  writes[0].descriptorCount = writes[1].descriptorCount = 1;
  writes[0].descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  writes[1].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  writes[0].pImageInfo = &in;
  writes[1].pImageInfo = &out;
  vkUpdateDescriptorSets(device_.handle(), 2, writes, 0, nullptr);
}

void GuiPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, gpu::Image& image,
                     const ImDrawData& draw_data, const ImFontAtlas& fonts, uint64_t fonts_number) {
  const bool new_fonts = fonts_number_ != fonts_number;
  if (new_fonts) upload_fonts(recorder, staging, fonts);
  fonts_number_ = fonts_number;
  tiles_.build(draw_data, {image.extent.width, image.extent.height});
  if (tiles_.tiles().empty()) return;
  bind(image);
  const auto tile_count = static_cast<uint32_t>(tiles_.tiles().size());
  const uint32_t in_row = std::min(tile_count, FIRE3DV_GUI_TILES_IN_ROW);

  const gpu_types::GuiPush push{
      staging.write(std::span<const gpu_types::GuiPrimitive>(tiles_.primitives())).address,
      staging.write(std::span<const gpu_types::GuiTile>(tiles_.tiles())).address,
      staging.write(std::span<const uint32_t>(tiles_.entries())).address,
      tile_count,
      image.extent.width,
      image.extent.height};
  recorder.pass("gui", {Use(fonts_, access::compute_sample), Use(image, access::compute_write)},
                [&](VkCommandBuffer commands) {
                  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
                  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1,
                                          &set_.get(), 0, nullptr);
                  vkCmdPushConstants(commands, layout_.get(), VK_SHADER_STAGE_ALL, 0, sizeof push, &push);
                  vkCmdDispatch(commands, in_row, (tile_count + in_row - 1) / in_row, 1);
                });
}

}  // namespace fire3dv::gui
