#include "renderer/gui/gui_tiles.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "protocol/base/error.h"

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

}  // namespace fire3dv::gui
