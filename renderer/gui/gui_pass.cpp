#include "renderer/gui/gui_pass.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "shaders/shared/bindings.h"

namespace fire3dv::gui {

namespace {

using gpu_types::GuiPrimitive;

constexpr uint32_t kEnd = UINT32_MAX;
constexpr float kTile = FIRE3DV_GUI_TILE;

glm::vec4 corner(const ImDrawVert& vertex, const ImVec2& origin) {
  return {vertex.pos.x - origin.x, vertex.pos.y - origin.y, vertex.uv.x, vertex.uv.y};
}

// True for two triangles that form an axis-aligned rectangle in ImGui's vertex order: glyphs, backgrounds and
// frames, the bulk of the panels.
bool is_rectangle(const ImDrawVert* vertices, const ImDrawIdx* index) {
  if (index[3] != index[0] || index[4] != index[2]) return false;
  const ImDrawVert &a = vertices[index[0]], &b = vertices[index[1]], &c = vertices[index[2]],
                   &d = vertices[index[5]];
  const bool is_upright = a.pos.y == b.pos.y && b.pos.x == c.pos.x && c.pos.y == d.pos.y &&
                          d.pos.x == a.pos.x && a.pos.x < c.pos.x && a.pos.y < c.pos.y;
  const bool is_straight = a.uv.y == b.uv.y && b.uv.x == c.uv.x && c.uv.y == d.uv.y && d.uv.x == a.uv.x;
  return is_upright && is_straight && a.col == b.col && b.col == c.col && c.col == d.col;
}

struct Box {
  glm::vec2 low, high;
};

Box box_of(const GuiPrimitive& primitive) {
  Box box{glm::min(glm::vec2(primitive.a), glm::vec2(primitive.b)),
          glm::max(glm::vec2(primitive.a), glm::vec2(primitive.b))};
  if (primitive.kind == FIRE3DV_GUI_TRIANGLE) {
    box.low = glm::min(box.low, glm::vec2(primitive.c));
    box.high = glm::max(box.high, glm::vec2(primitive.c));
  }
  return {glm::max(box.low, glm::vec2(primitive.clip.x, primitive.clip.y)),
          glm::min(box.high, glm::vec2(primitive.clip.z, primitive.clip.w))};
}

}  // namespace

void GuiTiles::build(const ImDrawData& draw_data, glm::uvec2 image_px) {
  image_px_ = image_px;
  primitives_.clear();
  tiles_.clear();
  entries_.clear();
  links_.clear();
  add(draw_data);

  const glm::uvec2 grid = (image_px + FIRE3DV_GUI_TILE - 1u) / FIRE3DV_GUI_TILE;
  head_.assign(size_t{grid.x} * grid.y, kEnd);
  covered_.assign(head_.size(), false);
  // Back to front in reverse: occluders come first, and the lists end up in drawing order.
  for (size_t i = primitives_.size(); i-- > 0;) link(static_cast<uint32_t>(i), grid);

  for (uint32_t y = 0; y < grid.y; ++y) {
    for (uint32_t x = 0; x < grid.x; ++x) {
      const uint32_t head = head_[size_t{y} * grid.x + x];
      if (head == kEnd) continue;
      const auto first = static_cast<uint32_t>(entries_.size());
      for (uint32_t at = head; at != kEnd; at = links_[at].next) entries_.push_back(links_[at].primitive);
      tiles_.push_back({x | y << 16, first, static_cast<uint32_t>(entries_.size()) - first});
    }
  }
}

void GuiTiles::add(const ImDrawData& draw_data) {
  for (int l = 0; l < draw_data.CmdListsCount; ++l) {
    const ImDrawList& list = *draw_data.CmdLists[l];
    for (const ImDrawCmd& command : list.CmdBuffer) {
      FIRE3DV_ASSERT(command.UserCallback == nullptr);  // panels have none
      const glm::vec4 clip = glm::clamp(
          glm::vec4(command.ClipRect.x, command.ClipRect.y, command.ClipRect.z, command.ClipRect.w) -
              glm::vec4(draw_data.DisplayPos.x, draw_data.DisplayPos.y, draw_data.DisplayPos.x,
                        draw_data.DisplayPos.y),
          glm::vec4(0), glm::vec4(image_px_, image_px_));
      const ImDrawVert* const vertices = list.VtxBuffer.Data + command.VtxOffset;
      const ImDrawIdx* index = list.IdxBuffer.Data + command.IdxOffset;
      const ImDrawIdx* const end = index + command.ElemCount;
      while (index < end) {
        const bool rectangle = end - index >= 6 && is_rectangle(vertices, index);
        const ImDrawVert &a = vertices[index[0]], &b = vertices[index[rectangle ? 2 : 1]],
                         &c = vertices[index[2]];
        GuiPrimitive primitive{corner(a, draw_data.DisplayPos),
                               corner(b, draw_data.DisplayPos),
                               corner(c, draw_data.DisplayPos),
                               clip,
                               a.col,
                               b.col,
                               c.col,
                               rectangle ? FIRE3DV_GUI_RECTANGLE : FIRE3DV_GUI_TRIANGLE};
        index += rectangle ? 6 : 3;
        if (((a.col | b.col | c.col) & IM_COL32_A_MASK) == 0) continue;
        if (!rectangle) {
          // The shader requires one winding. Degenerate triangles have no interior and no weights.
          const glm::vec2 ab = glm::vec2(primitive.b) - glm::vec2(primitive.a),
                          ac = glm::vec2(primitive.c) - glm::vec2(primitive.a);
          const float area = ab.x * ac.y - ab.y * ac.x;
          if (!(std::abs(area) > 1e-6f)) continue;
          if (area < 0) {
            std::swap(primitive.b, primitive.c);
            std::swap(primitive.color_b, primitive.color_c);
          }
        }
        primitives_.push_back(primitive);
      }
    }
  }
}

void GuiTiles::link(uint32_t number, glm::uvec2 grid) {
  const GuiPrimitive& primitive = primitives_[number];
  const Box box = box_of(primitive);
  if (!(box.low.x < box.high.x && box.low.y < box.high.y)) return;
  const glm::uvec2 first(box.low / kTile);
  const glm::uvec2 last = glm::min(glm::uvec2(box.high / kTile), grid - 1u);
  // One texel of the fonts is opaque; untextured primitives use it at all vertices.
  const bool is_opaque = primitive.kind == FIRE3DV_GUI_RECTANGLE && primitive.color_a >> 24 == 0xff &&
                         primitive.a.z == primitive.b.z && primitive.a.w == primitive.b.w;
  for (uint32_t y = first.y; y <= last.y; ++y) {
    for (uint32_t x = first.x; x <= last.x; ++x) {
      const size_t tile = size_t{y} * grid.x + x;
      if (covered_[tile]) continue;
      links_.push_back({number, head_[tile]});
      head_[tile] = static_cast<uint32_t>(links_.size() - 1);
      const glm::vec2 low(static_cast<float>(x) * kTile, static_cast<float>(y) * kTile);
      const glm::vec2 high = glm::min(low + kTile, image_px_);
      covered_[tile] = is_opaque && box.low.x <= low.x && box.low.y <= low.y && box.high.x >= high.x &&
                       box.high.y >= high.y;
    }
  }
}

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
