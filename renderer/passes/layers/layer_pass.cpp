#include "renderer/passes/layers/layer_pass.h"

#include <algorithm>
#include <array>

#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

constexpr VkDeviceSize kMaxBytes = VkDeviceSize{256} << 20, kMinBytes = VkDeviceSize{8} << 20;
constexpr VkDeviceSize kSlotsBytes = (FIRE3DV_LAYERS_PER_PASS + 1) * sizeof(uint64_t);
constexpr VkDeviceSize kKeyBytes = kSlotsBytes + sizeof(gpu_types::LayerRest);
constexpr uint32_t kGroup = 64;  // pixels of a workgroup that composites

constexpr VkPipelineStageFlags2 kStages =
    VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT |
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT |
    VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
constexpr gpu::Access kLayerAccess{kStages, VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT, true};

// Per pixel: the state, and for each sample and slot a record.
VkDeviceSize layer_bytes(VkSampleCountFlagBits samples) {
  return sizeof(uint64_t) + samples * sizeof(gpu_types::LayerSample) +
         FIRE3DV_LAYERS_PER_PASS * sizeof(gpu_types::LayerRecord);
}

std::vector<VkRect2D> split(const VkRect2D& area, uint64_t capacity_px) {
  const auto rows = static_cast<uint32_t>(
      std::min<uint64_t>(std::max<uint64_t>(capacity_px / area.extent.width, 1), area.extent.height));
  std::vector<VkRect2D> parts;
  for (uint32_t row = 0; row < area.extent.height; row += rows)
    parts.push_back({{area.offset.x, area.offset.y + static_cast<int32_t>(row)},
                     {area.extent.width, std::min(rows, area.extent.height - row)}});
  return parts;
}

void wait(VkCommandBuffer commands) {
  gpu::wait_for(commands, kStages, kStages);
}

}  // namespace

LayerPass::LayerPass(gpu::Device& device, VkPipelineLayout layout, VkSampleCountFlagBits samples)
    : device_(device),
      layout_(layout),
      samples_(samples),
      composite_(gpu::create_compute_pipeline(device, layout, "layers_composite.comp")) {
  gpu::GraphicsPipelineInfo info;
  info.samples = samples;
  info.vertex_shader = "background.vert";
  info.depth_format = VK_FORMAT_UNDEFINED;
  info.depth_write = false;
  info.color_format = VK_FORMAT_R16G16B16A16_SFLOAT;
  info.blend = true;
  info.dual_source = device.report().dual_source_blend;
  const bool is_single = samples == VK_SAMPLE_COUNT_1_BIT;
  if (info.dual_source)
    info.fragment_shader = is_single ? "layers_resolve_blend_1.frag" : "layers_resolve_blend_4.frag";
  else
    info.fragment_shader = is_single ? "layers_resolve_1.frag" : "layers_resolve_4.frag";
  resolve_ = gpu::create_graphics_pipeline(device, layout, info);
  work_ = gpu::create_buffer(device, FIRE3DV_LAYER_PASSES * sizeof(gpu_types::LayerWork),
                             VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
                             gpu::Memory::device);
}

void LayerPass::allocate(VkExtent2D extent) {
  const VkDeviceSize pixel_bytes = kKeyBytes + layer_bytes(samples_);
  const VkDeviceSize image_bytes = VkDeviceSize{extent.width} * extent.height * pixel_bytes;
  VkDeviceSize bytes = std::min(kMaxBytes, image_bytes);
  if (bytes <= wanted_bytes_ && extent.width <= capacity_px_) return;
  const VkDeviceSize wanted = std::max(bytes, wanted_bytes_);
  bytes = wanted;
  for (;; bytes /= 2) {
    // One row at least.
    const uint64_t pixels = std::max<uint64_t>(bytes / pixel_bytes, extent.width);
    try {
      keys_ = {};
      layers_ = {};
      capacity_px_ = 0;
      are_keys_zero_ = false;
      keys_ = gpu::create_buffer(device_, pixels * kKeyBytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                 gpu::Memory::device);
      layers_ = gpu::create_buffer(device_, pixels * layer_bytes(samples_),
                                   VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
      capacity_px_ = pixels;
      wanted_bytes_ = wanted;
      return;
    } catch (const gpu::VulkanFailure& failure) {
      if (!gpu::is_out_of_memory(failure) || bytes <= kMinBytes) throw;
    }
  }
}

VkDeviceAddress LayerPass::upload_target(gpu::StagingRing& staging, const VkRect2D& part) const {
  const uint64_t pixels = uint64_t{part.extent.width} * part.extent.height;
  gpu_types::LayerTarget target{};
  target.keys = keys_.address;
  target.rests = keys_.address + pixels * kSlotsBytes;
  target.samples = layers_.address;
  target.states = target.samples + pixels * samples_ * sizeof(gpu_types::LayerSample);
  target.records = target.states + pixels * sizeof(uint64_t);
  target.work = work_.address;
  target.first_x = static_cast<uint32_t>(part.offset.x);
  target.first_y = static_cast<uint32_t>(part.offset.y);
  target.width = part.extent.width;
  target.height = part.extent.height;
  target.sample_count = samples_;
  return staging.write(std::span<const gpu_types::LayerTarget>(&target, 1)).address;
}

void LayerPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, Targets& targets,
                       const VkRect2D& area, std::span<const LayerDraws> draws) {
  if (!are_keys_zero_) {
    recorder.pass("layers", {Use(keys_, access::transfer_write), Use(layers_, access::transfer_write)},
                  [&](VkCommandBuffer commands) {
                    vkCmdFillBuffer(commands, keys_.get(), 0, VK_WHOLE_SIZE, 0);
                    vkCmdFillBuffer(commands, layers_.get(), 0, VK_WHOLE_SIZE, 0);
                  });
    are_keys_zero_ = true;
  }
  std::vector<Use> uses{Use(keys_, kLayerAccess), Use(layers_, kLayerAccess), Use(work_, kLayerAccess),
                        Use(targets.depth, access::depth_target), Use(targets.hdr, access::color_target)};
  for (const LayerDraws& of_source : draws)
    uses.insert(uses.end(), of_source.uses.begin(), of_source.uses.end());
  recorder.pass("layers", uses, [&](VkCommandBuffer commands) {
    for (const VkRect2D& part : split(area, capacity_px_))
      record_part(commands, targets, part, upload_target(staging, part), draws);
  });
}

void LayerPass::record_part(VkCommandBuffer commands, const Targets& targets, const VkRect2D& part,
                            VkDeviceAddress target, std::span<const LayerDraws> draws) const {
  wait(commands);
  const uint32_t pixels = part.extent.width * part.extent.height;
  std::array<gpu_types::LayerWork, FIRE3DV_LAYER_PASSES> work{};
  for (gpu_types::LayerWork& of_pass : work) of_pass = {0, 0, 1, 1};
  work[0] = {FIRE3DV_LAYER_DRAWS, (pixels + kGroup - 1) / kGroup, 1, 1};
  vkCmdUpdateBuffer(commands, work_.get(), 0, sizeof(work), work.data());
  wait(commands);

  VkRenderingAttachmentInfo depth{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
  depth.imageView = targets.depth.view.get();
  depth.imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
  depth.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
  depth.storeOp = VK_ATTACHMENT_STORE_OP_NONE;  // it is read only
  VkRenderingInfo rendering{VK_STRUCTURE_TYPE_RENDERING_INFO};
  rendering.renderArea = part;
  rendering.layerCount = 1;
  rendering.pDepthAttachment = &depth;
  const VkViewport viewport{
      0, 0, static_cast<float>(targets.extent.width), static_cast<float>(targets.extent.height), 0, 1};
  for (uint32_t pass = 0; pass < FIRE3DV_LAYER_PASSES; ++pass) {
    for (const LayerStep::Stage stage : {LayerStep::Stage::keys, LayerStep::Stage::light}) {
      vkCmdBeginRendering(commands, &rendering);
      vkCmdSetViewport(commands, 0, 1, &viewport);
      vkCmdSetScissor(commands, 0, 1, &part);
      for (const LayerDraws& of_source : draws)
        of_source.record(commands,
                         {stage, pass, target, work_.get(), pass * sizeof(gpu_types::LayerWork), rendering});
      vkCmdEndRendering(commands);
      wait(commands);
    }
    composite(commands, target, pass, pixels);
    wait(commands);
  }
  resolve(commands, targets, part, target);
}

void LayerPass::composite(VkCommandBuffer commands, VkDeviceAddress target, uint32_t pass,
                          uint32_t pixels) const {
  gpu_types::LayerPush push{};
  push.target = target;
  push.pass = pass;
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, composite_.get());
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
  if (pass == 0)
    vkCmdDispatch(commands, (pixels + kGroup - 1) / kGroup, 1, 1);
  else
    vkCmdDispatchIndirect(commands, work_.get(),
                          pass * sizeof(gpu_types::LayerWork) + offsetof(gpu_types::LayerWork, groups_x));
}

void LayerPass::resolve(VkCommandBuffer commands, const Targets& targets, const VkRect2D& part,
                        VkDeviceAddress target) const {
  VkRenderingAttachmentInfo color{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
  color.imageView = targets.hdr.view.get();
  color.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  color.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
  color.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  VkRenderingInfo rendering{VK_STRUCTURE_TYPE_RENDERING_INFO};
  rendering.renderArea = part;
  rendering.layerCount = 1;
  rendering.colorAttachmentCount = 1;
  rendering.pColorAttachments = &color;
  vkCmdBeginRendering(commands, &rendering);
  const VkViewport viewport{
      0, 0, static_cast<float>(targets.extent.width), static_cast<float>(targets.extent.height), 0, 1};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &part);
  vkCmdSetCullMode(commands, VK_CULL_MODE_NONE);
  vkCmdSetFrontFace(commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
  gpu_types::LayerPush push{};
  push.target = target;
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, resolve_.get());
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
  vkCmdDraw(commands, 3, 1, 0, 0);
  vkCmdEndRendering(commands);
}

}  // namespace fire3dv::passes
