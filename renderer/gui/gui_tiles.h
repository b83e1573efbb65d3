// Panels as lists for the GPU: what ImGui lays out, as rectangles and triangles, and which of them are in
// which tile of the image. Tiles without any are left out, and what an opaque rectangle hides is dropped.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "shaders/shared/gui_types.h"

struct ImDrawData;

namespace fire3dv::gui {

class GuiTiles {
 public:
  // Lists of what is drawn onto an image of this size. Valid until the next call.
  void build(const ImDrawData& draw_data, glm::uvec2 image_px);

  const std::vector<gpu_types::GuiPrimitive>& primitives() const { return primitives_; }
  const std::vector<gpu_types::GuiTile>& tiles() const { return tiles_; }
  const std::vector<uint32_t>& entries() const { return entries_; }  // primitives of tiles, as they are drawn

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
