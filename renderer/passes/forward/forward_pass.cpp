#include "renderer/passes/forward/forward_pass.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "renderer/passes/resources/draw_batches.h"
#include "renderer/passes/resources/shader_variant.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

constexpr gpu::Access kIndirectRead{VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
                                    VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, false};
constexpr gpu::Access kIndexRead{VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, VK_ACCESS_2_INDEX_READ_BIT, false};

VkDrawIndexedIndirectCommand command_of(const scene::ClusteredPrimitive& primitive, uint32_t draw) {
  return {primitive.index_count, 1, primitive.first_index, static_cast<int32_t>(primitive.first_vertex),
          draw};
}

// World-space centre of a draw. For a skinned primitive, the mean of its joint boxes' centres.
glm::vec3 center_of(const scene::Scene& source, const state::PoseState& poses, const Draw& draw) {
  const scene::Primitive& primitive = source.primitives[draw.primitive];
  const uint32_t skin = source.nodes[draw.node].skin;
  if (skin == scene::kNone || primitive.joint_bounds_count == 0) {
    const glm::vec3 center_node = 0.5f * (primitive.bounds_min + primitive.bounds_max);
    return glm::vec3(poses.world_from_node(draw.node) * glm::vec4(center_node, 1));
  }
  glm::vec3 sum(0);
  for (uint32_t i = 0; i < primitive.joint_bounds_count; ++i) {
    const scene::JointBounds& box = source.joint_bounds[primitive.first_joint_bounds + i];
    const scene::Joint& joint = source.joints[source.skins[skin].first_joint + box.joint];
    const glm::vec4 center_mesh(0.5f * (box.bounds_min + box.bounds_max), 1);
    sum += glm::vec3(poses.world_from_node(joint.node) * (joint.joint_from_mesh * center_mesh));
  }
  return sum / static_cast<float>(primitive.joint_bounds_count);
}

// Sorts blended draws back to front by the distance of their centres in the current pose. The CPU sorts,
// since blended draws are few.
std::vector<VkDrawIndexedIndirectCommand> sorted_blend_commands(const GpuScene& scene,
                                                                const scene::Scene& source,
                                                                const state::PoseState& poses,
                                                                const DrawBin& bin,
                                                                const glm::vec3& eye_world) {
  std::vector<std::pair<float, uint32_t>> order;
  for (uint32_t i = bin.first_draw; i < bin.first_draw + bin.draw_count; ++i) {
    const Draw& draw = scene.draw_list.draws[i];
    const glm::vec3 offset = center_of(source, poses, draw) - eye_world;
    order.emplace_back(-glm::dot(offset, offset), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<VkDrawIndexedIndirectCommand> commands;
  for (const auto& [key, i] : order) {
    commands.push_back(command_of(scene.geometry_of(scene.draw_list.draws[i]), i));
  }
  return commands;
}

// Splits draws at the limit of a batch; returns the number of draws of each batch. first_instance_step: added
// to firstInstance for each further piece of a draw.
std::vector<VkDrawIndexedIndirectCommand> split_into_batches(
    std::span<const VkDrawIndexedIndirectCommand> commands, uint32_t max_indices,
    uint32_t first_instance_step, std::vector<uint32_t>& batches) {
  std::vector<VkDrawIndexedIndirectCommand> split;
  batches.assign(1, 0);
  uint32_t used = 0;
  for (VkDrawIndexedIndirectCommand rest : commands) {
    while (rest.indexCount > 0) {
      VkDrawIndexedIndirectCommand& piece = split.emplace_back(rest);
      piece.indexCount = std::min(rest.indexCount, max_indices);
      if (used + piece.indexCount > max_indices) {
        batches.push_back(0);
        used = 0;
      }
      ++batches.back();
      used += piece.indexCount;
      rest.firstIndex += piece.indexCount;
      rest.firstInstance += first_instance_step;
      rest.indexCount -= piece.indexCount;
    }
  }
  return split;
}

VkPrimitiveTopology vk_topology(scene::Topology topology) {
  switch (topology) {
    case scene::Topology::triangles:
      return VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    case scene::Topology::lines:
      return VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
    case scene::Topology::points:
      return VK_PRIMITIVE_TOPOLOGY_POINT_LIST;
  }
  return VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
}

void draw_fullscreen(VkCommandBuffer commands, const gpu::Pipeline& pipeline) {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.get());
  vkCmdSetCullMode(commands, VK_CULL_MODE_NONE);
  vkCmdSetFrontFace(commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
  vkCmdDraw(commands, 3, 1, 0, 0);
}

constexpr float kMarginPixels = 4;  // covers line and point sizes, and rounding

struct Bounds {
  glm::vec2 low{1e30f}, high{-1e30f};  // pixels
};

// Returns false if part of the box cannot be projected.
bool add_box(const glm::mat4& clip_from_node, const scene::Primitive& primitive, const glm::vec2& size,
             Bounds& bounds) {
  glm::vec2 low(1e30f), high(-1e30f);
  int behind_near = 0, in_front = 0;
  for (int i = 0; i < 8; ++i) {
    const glm::vec3 corner(i & 1 ? primitive.bounds_max.x : primitive.bounds_min.x,
                           i & 2 ? primitive.bounds_max.y : primitive.bounds_min.y,
                           i & 4 ? primitive.bounds_max.z : primitive.bounds_min.z);
    const glm::vec4 clip = clip_from_node * glm::vec4(corner, 1);
    const bool is_behind = !(clip.w > 0) || clip.z > clip.w;
    ++(is_behind ? behind_near : in_front);
    if (is_behind) continue;
    const glm::vec2 pixel = (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * size;
    low = glm::min(low, pixel);
    high = glm::max(high, pixel);
  }
  if (in_front == 0) return true;  // outside of the view
  if (behind_near != 0 || !std::isfinite(low.x + low.y + high.x + high.y)) return false;
  bounds.low = glm::min(bounds.low, low);
  bounds.high = glm::max(bounds.high, high);
  return true;
}

}  // namespace

ForwardPass::ForwardPass(gpu::Device& device, VkPipelineLayout layout, VkSampleCountFlagBits samples)
    : device_(device), layout_(layout), samples_(samples) {
  gpu::GraphicsPipelineInfo info;
  info.samples = samples;
  info.vertex_shader = "background.vert";
  info.fragment_shader = knows_visible_samples() ? "background_visible.frag" : "background.frag";
  info.depth_write = false;
  info.color_format = VK_FORMAT_R16G16B16A16_SFLOAT;
  background_ = gpu::create_graphics_pipeline(device, layout, info);
}

bool ForwardPass::knows_visible_samples() const {
  return samples_ == VK_SAMPLE_COUNT_4_BIT && device_.report().visible_coverage;
}

const gpu::Pipeline& ForwardPass::pipeline(const DrawBin& bin, Stage stage, uint32_t material_flags) {
  if (stage == Stage::depth || stage == Stage::layer_keys) material_flags = 0;
  gpu::Pipeline& known = pipelines_[{bin.topology, bin.alpha_mode, stage, material_flags}];
  if (known) return known;
  const bool visible_places = knows_visible_samples();
  std::string fragment_shader;
  ShaderVariant variant;
  variant.material_flags = material_flags;
  const auto constants = variant.constants();
  gpu::GraphicsPipelineInfo info;
  info.vertex_shader = "forward.vert";
  info.samples = samples_;
  info.topology = vk_topology(bin.topology);
  if (stage == Stage::depth) {
    if (bin.alpha_mode == scene::AlphaMode::mask) {
      info.fragment_shader = visible_places ? "depth_mask_4.frag" : "depth_mask.frag";
    }
  } else if (stage == Stage::layer_keys) {
    info.vertex_shader = "forward_layers.vert";
    info.fragment_shader = "layer_keys.frag";
    info.depth_write = false;
  } else if (stage == Stage::layer_light) {
    info.vertex_shader = "forward_layers.vert";
    info.depth_write = false;
    fragment_shader = "forward_layers";
    if (device_.ray_query()) fragment_shader += gpu::traces_to_boxes(device_) ? "_ray_boxes" : "_ray";
    fragment_shader += ".frag";
    info.fragment_shader = fragment_shader;
    info.fragment_constants = constants;
  } else {
    info.color_format = VK_FORMAT_R16G16B16A16_SFLOAT;
    info.depth_write = false;
    info.blend = bin.blended();
    info.dual_source = info.blend && device_.report().dual_source_blend;
    if (!info.blend) info.depth_compare = VK_COMPARE_OP_EQUAL;  // the depth pass has written the depth
    fragment_shader = info.dual_source        ? "forward_blend"
                      : bin.is_forward_only() ? "forward_only"
                      : visible_places        ? "forward_visible"
                                              : "forward";
    if (device_.ray_query()) fragment_shader += gpu::traces_to_boxes(device_) ? "_ray_boxes" : "_ray";
    fragment_shader += ".frag";
    info.fragment_shader = fragment_shader;
    info.fragment_constants = constants;
  }
  known = gpu::create_graphics_pipeline(device_, layout_, info);
  return known;
}

void ForwardPass::upload_commands(gpu::Recorder& recorder, gpu::StagingRing& staging, const GpuScene& scene) {
  if (commands_revision_ == scene.draw_list_revision) return;
  std::vector<VkDrawIndexedIndirectCommand> commands;
  for (uint32_t i = 0; i < scene.draw_list.draws.size(); ++i) {
    commands.push_back(command_of(scene.geometry_of(scene.draw_list.draws[i]), i));
  }
  const VkDeviceSize bytes = commands.size() * sizeof(commands[0]);
  commands_ = gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, gpu::Memory::device);
  const gpu::StagingRing::Piece piece =
      staging.write(std::span<const VkDrawIndexedIndirectCommand>(commands));
  recorder.pass("draw commands", {Use(commands_, access::transfer_write)},
                [&](VkCommandBuffer commands_buffer) {
                  const VkBufferCopy copy{piece.offset, 0, bytes};
                  if (bytes) vkCmdCopyBuffer(commands_buffer, piece.buffer, commands_.get(), 1, &copy);
                });
  commands_revision_ = scene.draw_list_revision;
}

std::vector<ForwardPass::BinCommands> ForwardPass::bin_commands(gpu::StagingRing& staging,
                                                                const Frame& frame) const {
  std::vector<BinCommands> of_bins;
  for (const DrawBin& bin : frame.scene.draw_list.bins) {
    if (bin.blended()) {
      const auto sorted =
          sorted_blend_commands(frame.scene, frame.source, frame.poses, bin, frame.view.eye_world);
      std::vector<uint32_t> batches{static_cast<uint32_t>(sorted.size())};
      const bool in_batches = staging.has_limit() && bin.topology == scene::Topology::triangles;
      const uint32_t step = frame.in_layers ? static_cast<uint32_t>(frame.scene.draw_list.draws.size()) : 0;
      const std::vector<VkDrawIndexedIndirectCommand> commands =
          in_batches ? split_into_batches(sorted, 3 * triangles_per_batch(frame.area.extent), step, batches)
                     : sorted;
      const gpu::StagingRing::Piece piece =
          staging.write(std::span<const VkDrawIndexedIndirectCommand>(commands));
      of_bins.push_back({piece.buffer, piece.offset, std::move(batches)});
    } else {
      of_bins.push_back(
          {commands_.get(), bin.first_draw * sizeof(VkDrawIndexedIndirectCommand), {bin.draw_count}});
    }
  }
  return of_bins;
}

// goes_on: with another batch of draws.
void ForwardPass::begin(VkCommandBuffer commands, const Frame& frame, Stage stage, bool goes_on) const {
  Targets& targets = frame.targets;
  VkRenderingAttachmentInfo color{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
  color.imageView = targets.hdr.view.get();
  color.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  color.loadOp = frame.visibility || goes_on ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR;
  color.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  const glm::vec3& background = frame.background.color;
  // Alpha 0: the colour is display-referred.
  color.clearValue.color = {{background.r, background.g, background.b, 0}};
  VkRenderingAttachmentInfo depth{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
  depth.imageView = targets.depth.view.get();
  depth.imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL;
  depth.loadOp = stage == Stage::depth ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
  depth.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  depth.clearValue.depthStencil = {0, 0};
  VkRenderingInfo rendering{VK_STRUCTURE_TYPE_RENDERING_INFO};
  rendering.renderArea = frame.area;
  rendering.layerCount = 1;
  rendering.colorAttachmentCount = stage == Stage::color ? 1 : 0;
  rendering.pColorAttachments = &color;
  rendering.pDepthAttachment = &depth;
  vkCmdBeginRendering(commands, &rendering);

  const VkViewport viewport{
      0, 0, static_cast<float>(targets.extent.width), static_cast<float>(targets.extent.height), 0, 1};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &rendering.renderArea);
  const VkDescriptorSet set = frame.scene.textures.set();
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set, 0, nullptr);
  vkCmdBindIndexBuffer(commands, frame.scene.indices.get(), 0, VK_INDEX_TYPE_UINT32);
}

void ForwardPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Frame& frame) {
  GpuScene& scene = frame.scene;
  upload_commands(recorder, staging, scene);
  bin_commands_ = bin_commands(staging, frame);
  const std::vector<BinCommands>& of_bins = bin_commands_;
  std::vector<Use> depth_uses{Use(commands_, kIndirectRead), Use(scene.indices, kIndexRead),
                              Use(scene.draws, access::draw_read),
                              Use(frame.targets.depth, access::depth_target, true)};
  scene.add_reads(depth_uses, access::draw_read);
  if (frame.visibility) depth_uses.emplace_back(frame.visibility->buffer, access::draw_read);
  std::vector<Use> color_uses{Use(commands_, kIndirectRead), Use(scene.indices, kIndexRead),
                              Use(scene.draws, access::draw_read),
                              Use(frame.targets.depth, access::depth_target),
                              Use(frame.targets.hdr, access::color_target, !frame.visibility)};
  scene.add_reads(color_uses, access::draw_read);
  if (device_.ray_query()) color_uses.emplace_back(scene.top_level.storage(), access::draw_trace);
  if (frame.shadows) frame.shadows->add_reads(color_uses, access::draw_read);

  // Depth pre-pass: hidden fragments are not shaded, and fragments know their visible samples.
  recorder.pass("depth", depth_uses, [&](VkCommandBuffer commands) {
    begin(commands, frame, Stage::depth);
    if (frame.visibility) draw_visible_depth(commands, frame);
    draw_bins(commands, frame, Stage::depth, false, of_bins);
    vkCmdEndRendering(commands);
  });
  recorder.pass("forward", color_uses, [&](VkCommandBuffer commands) {
    begin(commands, frame, Stage::color);
    draw_bins(commands, frame, Stage::color, false, of_bins);
    // Behind solid surfaces and before the blended draws.
    const bool is_plain =
        !frame.background.show_environment && !frame.background.zenith && !frame.view.ground;
    if (!is_plain && !frame.visibility) {
      const gpu_types::ForwardPush push{frame.globals};  // no draw before may have set it
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      draw_fullscreen(commands, background_);
    }
    if (!frame.in_layers) draw_bins(commands, frame, Stage::color, true, of_bins);
    vkCmdEndRendering(commands);
  });
}

LayerDraws ForwardPass::layer_draws(const Frame& frame) {
  LayerDraws draws;
  draws.uses = {Use(frame.scene.indices, kIndexRead), Use(frame.scene.draws, access::draw_read)};
  frame.scene.add_reads(draws.uses, access::draw_read);
  if (device_.ray_query()) draws.uses.emplace_back(frame.scene.top_level.storage(), access::draw_trace);
  if (frame.shadows) frame.shadows->add_reads(draws.uses, access::draw_read);
  draws.record = [this, &frame](VkCommandBuffer commands, const LayerStep& step) {
    draw_layers(commands, frame, step);
  };
  return draws;
}

void ForwardPass::draw_layers(VkCommandBuffer commands, const Frame& frame, const LayerStep& step) {
  const VkDescriptorSet set = frame.scene.textures.set();
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set, 0, nullptr);
  vkCmdBindIndexBuffer(commands, frame.scene.indices.get(), 0, VK_INDEX_TYPE_UINT32);
  const Stage stage = step.stage == LayerStep::Stage::keys ? Stage::layer_keys : Stage::layer_light;
  gpu_types::LayerPush push{};
  push.globals = frame.globals;
  push.target = step.target;
  push.pass = step.pass;
  push.draw_count = static_cast<uint32_t>(frame.scene.draw_list.draws.size());
  push.piece_triangles = triangles_per_batch(frame.area.extent);
  const std::vector<DrawBin>& bins = frame.scene.draw_list.bins;
  for (size_t b = 0; b < bins.size(); ++b) {
    const DrawBin& bin = bins[b];
    if (!bin.blended()) continue;
    push.is_flat = bin.topology != scene::Topology::triangles;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS,
                      pipeline(bin, stage, frame.scene.material_flags).get());
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdSetCullMode(commands, bin.double_sided ? VK_CULL_MODE_NONE : VK_CULL_MODE_BACK_BIT);
    vkCmdSetFrontFace(commands, bin.mirrored ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
    uint32_t done = 0, end = 0;
    for (size_t batch = 0; batch < bin_commands_[b].batches.size(); ++batch) {
      if (batch > 0) {
        end_batch(commands);
        vkCmdBeginRendering(commands, &step.rendering);
      }
      end += bin_commands_[b].batches[batch];
      for (uint32_t count = 0; done < end; done += count) {
        count = std::min({end - done, device_.limits().maxDrawIndirectCount, FIRE3DV_LAYER_DRAWS});
        vkCmdDrawIndexedIndirectCount(commands, bin_commands_[b].buffer,
                                      bin_commands_[b].offset + done * sizeof(VkDrawIndexedIndirectCommand),
                                      step.draw_count, step.draw_count_offset, count,
                                      sizeof(VkDrawIndexedIndirectCommand));
      }
    }
  }
}

void ForwardPass::draw_visible_depth(VkCommandBuffer commands, const Frame& frame) {
  if (!visible_depth_) {
    gpu::GraphicsPipelineInfo info;
    info.vertex_shader = "background.vert";
    info.fragment_shader =
        samples_ == VK_SAMPLE_COUNT_4_BIT ? "visible_depth_4.frag" : "visible_depth_1.frag";
    info.samples = samples_;
    info.depth_compare = VK_COMPARE_OP_ALWAYS;
    visible_depth_ = gpu::create_graphics_pipeline(device_, layout_, info);
  }
  const gpu_types::VisibleDepthPush push{frame.visibility->buffer.address, frame.visibility->generation(),
                                         frame.targets.extent.width};
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
  draw_fullscreen(commands, visible_depth_);
}

void ForwardPass::draw_bins(VkCommandBuffer commands, const Frame& frame, Stage stage, bool blended,
                            const std::vector<BinCommands>& of_bins) {
  const gpu_types::ForwardPush push{frame.globals};
  const std::vector<DrawBin>& bins = frame.scene.draw_list.bins;
  for (size_t b = 0; b < bins.size(); ++b) {
    if (bins[b].blended() != blended || (frame.visibility && !bins[b].is_forward_only())) continue;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS,
                      pipeline(bins[b], stage, frame.scene.material_flags).get());
    // Push constants are set again for each pipeline: lavapipe loses them for fragment shaders after a
    // pipeline without one.
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    draw_bin(commands, bins[b], of_bins[b], frame);
  }
}

void ForwardPass::draw_bin(VkCommandBuffer commands, const DrawBin& bin, const BinCommands& bin_commands,
                           const Frame& frame) const {
  vkCmdSetCullMode(commands, bin.double_sided ? VK_CULL_MODE_NONE : VK_CULL_MODE_BACK_BIT);
  vkCmdSetFrontFace(commands, bin.mirrored ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
  uint32_t done = 0, end = 0;
  for (size_t batch = 0; batch < bin_commands.batches.size(); ++batch) {
    if (batch > 0) {
      end_batch(commands);
      begin(commands, frame, Stage::color, true);
    }
    end += bin_commands.batches[batch];
    // Without layers, the far side of a double-sided body is drawn before the near one.
    const bool in_sides = bin.blended() && bin.double_sided && bin.topology == scene::Topology::triangles;
    for (; in_sides && done < end; ++done) {
      for (const VkCullModeFlagBits culled : {VK_CULL_MODE_FRONT_BIT, VK_CULL_MODE_BACK_BIT}) {
        vkCmdSetCullMode(commands, culled);
        vkCmdDrawIndexedIndirect(commands, bin_commands.buffer,
                                 bin_commands.offset + done * sizeof(VkDrawIndexedIndirectCommand), 1,
                                 sizeof(VkDrawIndexedIndirectCommand));
      }
    }
    while (done < end) {  // a device may limit the draws of one command
      const uint32_t count = std::min(end - done, device_.limits().maxDrawIndirectCount);
      vkCmdDrawIndexedIndirect(commands, bin_commands.buffer,
                               bin_commands.offset + done * sizeof(VkDrawIndexedIndirectCommand), count,
                               sizeof(VkDrawIndexedIndirectCommand));
      done += count;
    }
  }
}

VkRect2D forward_bounds(const GpuScene& gpu_scene, const scene::Scene& scene, const state::PoseState& poses,
                        const View& view, VkExtent2D extent) {
  const VkRect2D whole{{0, 0}, extent};
  const glm::vec2 size(extent.width, extent.height);
  Bounds bounds;
  for (const DrawBin& bin : gpu_scene.draw_list.bins) {
    if (!bin.is_forward_only()) continue;
    for (uint32_t i = bin.first_draw; i < bin.first_draw + bin.draw_count; ++i) {
      const Draw& draw = gpu_scene.draw_list.draws[i];
      // A shift means per-instance vertices or an edited colour.
      if (gpu_scene.primitive_shift_of_node[draw.node] != 0) return whole;
      const glm::mat4 clip_from_node = view.clip_from_world * poses.world_from_node(draw.node);
      if (!add_box(clip_from_node, scene.primitives[draw.primitive], size, bounds)) return whole;
    }
  }
  const glm::vec2 low = glm::clamp(glm::floor(bounds.low - kMarginPixels), glm::vec2(0), size);
  const glm::vec2 high = glm::clamp(glm::ceil(bounds.high + kMarginPixels), glm::vec2(0), size);
  if (!(low.x < high.x && low.y < high.y)) return {{0, 0}, {0, 0}};
  return {{static_cast<int32_t>(low.x), static_cast<int32_t>(low.y)},
          {static_cast<uint32_t>(high.x - low.x), static_cast<uint32_t>(high.y - low.y)}};
}

}  // namespace fire3dv::passes
