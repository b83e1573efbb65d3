// Tile lists of panels for the GPU: ImGui's output as rectangles and triangles, binned into image tiles.
// Empty tiles are omitted, and primitives behind an opaque rectangle are dropped.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "shaders/shared/gui_types.h"

struct ImDrawData;

namespace fire3dv::gui {

class GuiTiles {
 public:
  // Builds the lists for an image of this size. Valid until the next call.
  void build(const ImDrawData& draw_data, glm::uvec2 image_px);

  const std::vector<gpu_types::GuiPrimitive>& primitives() const { return primitives_; }
  const std::vector<gpu_types::GuiTile>& tiles() const { return tiles_; }
  // Primitive indices of the tiles, in drawing order.
  const std::vector<uint32_t>& entries() const { return entries_; }

 private:
  struct Link {
    uint32_t primitive, next;
  };
  void add(const ImDrawData& draw_data);
  void link(uint32_t primitive, glm::uvec2 grid);

  glm::vec2 image_px_{0};
  std::vector<gpu_types::GuiPrimitive> primitives_;
  std::vector<gpu_types::GuiTile> tiles_;
  std::vector<uint32_t> entries_, head_;
  std::vector<Link> links_;
  std::vector<bool> covered_;
};

}  // namespace fire3dv::gui
