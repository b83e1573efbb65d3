#include "renderer/passes/forward_pass.h"

#include <algorithm>

#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

constexpr gpu::Access kIndirectRead{VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT,
                                    false};
constexpr gpu::Access kIndexRead{VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, VK_ACCESS_2_INDEX_READ_BIT, false};

VkDrawIndexedIndirectCommand command_of(const scene::ClusteredPrimitive& primitive, uint32_t draw) {
  return {primitive.index_count, 1, primitive.first_index, static_cast<int32_t>(primitive.first_vertex), draw};
}

// In the world. Of a skinned one the mean of the places of its joints' boxes.
glm::vec3 middle_of(const scene::Scene& source, const state::PoseState& poses, const Draw& draw) {
  const scene::Primitive& primitive = source.primitives[draw.primitive];
  const uint32_t skin = source.nodes[draw.node].skin;
  if (skin == scene::kNone || primitive.joint_bounds_count == 0) {
    const glm::vec3 middle_node = 0.5f * (primitive.bounds_min + primitive.bounds_max);
    return glm::vec3(poses.world_from_node(draw.node) * glm::vec4(middle_node, 1));
  }
  glm::vec3 sum(0);
  for (uint32_t i = 0; i < primitive.joint_bounds_count; ++i) {
    const scene::JointBounds& box = source.joint_bounds[primitive.first_joint_bounds + i];
    const scene::Joint& joint = source.joints[source.skins[skin].first_joint + box.joint];
    const glm::vec4 middle_mesh(0.5f * (box.bounds_min + box.bounds_max), 1);
    sum += glm::vec3(poses.world_from_node(joint.node) * (joint.joint_from_mesh * middle_mesh));
  }
  return sum / static_cast<float>(primitive.joint_bounds_count);
}

// Back to front by the distance of each primitive's middle, as the poses are now. On the CPU: blended draws are few,
// and their order is all that is needed of them.
std::vector<VkDrawIndexedIndirectCommand> sorted_blend_commands(const GpuScene& scene, const scene::Scene& source,
                                                                const state::PoseState& poses, const DrawBin& bin,
                                                                const glm::vec3& eye_world) {
  std::vector<std::pair<float, uint32_t>> order;
  for (uint32_t i = bin.first_draw; i < bin.first_draw + bin.draw_count; ++i) {
    const Draw& draw = scene.draw_list.draws[i];
    const glm::vec3 offset = middle_of(source, poses, draw) - eye_world;
    order.emplace_back(-glm::dot(offset, offset), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<VkDrawIndexedIndirectCommand> commands;
  for (const auto& [key, i] : order) {
    commands.push_back(command_of(scene.geometry_of(scene.draw_list.draws[i]), i));
  }
  return commands;
}

}  // namespace

ForwardPass::ForwardPass(gpu::Device& device, VkPipelineLayout layout, VkSampleCountFlagBits samples)
    : device_(device), layout_(layout) {
  gpu::GraphicsPipelineInfo info;
  info.vertex_shader = "forward.vert";
  info.samples = samples;
  depth_only_ = gpu::create_graphics_pipeline(device, layout, info);
  info.fragment_shader = device.ray_query() ? "forward_ray.frag" : "forward.frag";
  info.color_format = VK_FORMAT_R16G16B16A16_SFLOAT;
  opaque_ = gpu::create_graphics_pipeline(device, layout, info);
  info.blend = true;
  info.depth_write = false;
  info.dual_source = device.report().dual_source_blend;
  if (info.dual_source)
    info.fragment_shader = device.ray_query() ? "forward_blend_ray.frag" : "forward_blend.frag";
  blend_ = gpu::create_graphics_pipeline(device, layout, info);
  info.blend = info.dual_source = false;
  info.vertex_shader = "background.vert";
  info.fragment_shader = "background.frag";
  background_ = gpu::create_graphics_pipeline(device, layout, info);
  info.vertex_shader = "forward.vert";
  info.depth_write = true;
  info.fragment_shader = device.ray_query() ? "forward_mask_ray.frag" : "forward_mask.frag";
  mask_ = gpu::create_graphics_pipeline(device, layout, info);
}

const gpu::Pipeline& ForwardPass::pipeline(scene::AlphaMode mode) const {
  switch (mode) {
    case scene::AlphaMode::opaque: return opaque_;
    case scene::AlphaMode::mask: return mask_;
    case scene::AlphaMode::blend: return blend_;
  }
  return opaque_;
}

void ForwardPass::upload_commands(gpu::Recorder& recorder, gpu::UploadBelt& belt, const GpuScene& scene) {
  if (commands_revision_ == scene.draw_list_revision) return;
  std::vector<VkDrawIndexedIndirectCommand> commands;
  for (uint32_t i = 0; i < scene.draw_list.draws.size(); ++i) {
    commands.push_back(command_of(scene.geometry_of(scene.draw_list.draws[i]), i));
  }
  const VkDeviceSize bytes = commands.size() * sizeof(commands[0]);
  commands_ = gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, gpu::Memory::device);
  const gpu::UploadBelt::Piece piece = belt.write(std::span<const VkDrawIndexedIndirectCommand>(commands));
  recorder.pass("draw commands", {Use(commands_, access::transfer_write)}, [&](VkCommandBuffer commands_buffer) {
    const VkBufferCopy copy{piece.offset, 0, bytes};
    if (bytes) vkCmdCopyBuffer(commands_buffer, piece.buffer, commands_.get(), 1, &copy);
  });
  commands_revision_ = scene.draw_list_revision;
}

void ForwardPass::record(gpu::Recorder& recorder, gpu::UploadBelt& belt, GpuScene& scene, const scene::Scene& source,
                         const state::PoseState& poses, Targets& targets, const View& view, VkDeviceAddress globals,
                         const Background& background) {
  upload_commands(recorder, belt, scene);

  std::vector<BinCommands> bin_commands;
  for (const DrawBin& bin : scene.draw_list.bins) {
    if (bin.alpha_mode == scene::AlphaMode::blend) {
      const auto sorted = sorted_blend_commands(scene, source, poses, bin, view.eye_world);
      const gpu::UploadBelt::Piece piece = belt.write(std::span<const VkDrawIndexedIndirectCommand>(sorted));
      bin_commands.push_back({piece.buffer, piece.offset});
    } else {
      bin_commands.push_back({commands_.get(), bin.first_draw * sizeof(VkDrawIndexedIndirectCommand)});
    }
  }

  std::vector<Use> depth_uses{Use(commands_, kIndirectRead), Use(scene.indices, kIndexRead),
                              Use(scene.draws, access::draw_read)};
  scene.add_reads(depth_uses, access::draw_read);
  depth_uses.emplace_back(targets.depth, access::depth_target, true);
  std::vector<Use> color_uses = depth_uses;
  color_uses.back().discard = !device_.ray_query();
  color_uses.emplace_back(targets.hdr, access::color_target, true);
  if (device_.ray_query()) color_uses.emplace_back(scene.top_level.storage(), access::draw_trace);

  auto begin = [&](VkCommandBuffer commands, bool color_too, VkAttachmentLoadOp depth_load) {
    VkRenderingAttachmentInfo color{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    color.imageView = targets.hdr.view.get();
    color.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    color.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    color.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    color.clearValue.color = {{background.color.r, background.color.g, background.color.b, 1}};
    VkRenderingAttachmentInfo depth{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    depth.imageView = targets.depth.view.get();
    depth.imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
    depth.loadOp = depth_load;
    depth.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    depth.clearValue.depthStencil = {0, 0};
    VkRenderingInfo rendering{VK_STRUCTURE_TYPE_RENDERING_INFO};
    rendering.renderArea = {{0, 0}, targets.extent};
    rendering.layerCount = 1;
    rendering.colorAttachmentCount = color_too ? 1 : 0;
    rendering.pColorAttachments = &color;
    rendering.pDepthAttachment = &depth;
    vkCmdBeginRendering(commands, &rendering);

    const VkViewport viewport{0, 0, static_cast<float>(targets.extent.width),
                              static_cast<float>(targets.extent.height), 0, 1};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &rendering.renderArea);
    const VkDescriptorSet set = scene.textures.set();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set, 0, nullptr);
    const gpu_types::ForwardPush push{globals};
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdBindIndexBuffer(commands, scene.indices.get(), 0, VK_INDEX_TYPE_UINT32);
  };

  // Depth first where a fragment costs rays: none is traced for a surface that another hides.
  const bool depth_first = device_.ray_query();
  if (depth_first) {
    recorder.pass("depth", depth_uses, [&](VkCommandBuffer commands) {
      begin(commands, false, VK_ATTACHMENT_LOAD_OP_CLEAR);
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, depth_only_.get());
      for (size_t b = 0; b < scene.draw_list.bins.size(); ++b) {
        if (scene.draw_list.bins[b].alpha_mode != scene::AlphaMode::opaque) continue;
        draw_bin(commands, scene.draw_list.bins[b], bin_commands[b]);
      }
      vkCmdEndRendering(commands);
    });
  }
  recorder.pass("forward", color_uses, [&](VkCommandBuffer commands) {
    begin(commands, true, depth_first ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR);
    const auto draw_bins = [&](bool blended) {
      for (size_t b = 0; b < scene.draw_list.bins.size(); ++b) {
        const scene::AlphaMode mode = scene.draw_list.bins[b].alpha_mode;
        if ((mode == scene::AlphaMode::blend) != blended) continue;
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline(mode).get());
        draw_bin(commands, scene.draw_list.bins[b], bin_commands[b]);
      }
    };
    draw_bins(false);
    if (background.surroundings) {  // where nothing solid is, and before what blends over it
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, background_.get());
      vkCmdSetCullMode(commands, VK_CULL_MODE_NONE);
      vkCmdSetFrontFace(commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
      vkCmdDraw(commands, 3, 1, 0, 0);
    }
    draw_bins(true);
    vkCmdEndRendering(commands);
  });
}

void ForwardPass::draw_bin(VkCommandBuffer commands, const DrawBin& bin, const BinCommands& bin_commands) const {
  vkCmdSetCullMode(commands, bin.double_sided ? VK_CULL_MODE_NONE : VK_CULL_MODE_BACK_BIT);
  vkCmdSetFrontFace(commands, bin.mirrored ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
  uint32_t done = 0;
  while (done < bin.draw_count) {  // a device may take fewer draws in one command
    const uint32_t count = std::min(bin.draw_count - done, device_.limits().maxDrawIndirectCount);
    vkCmdDrawIndexedIndirect(commands, bin_commands.buffer,
                             bin_commands.offset + done * sizeof(VkDrawIndexedIndirectCommand), count,
                             sizeof(VkDrawIndexedIndirectCommand));
    done += count;
  }
}

}  // namespace fire3dv::passes
