// Tiles of a screenshot that is larger than one image should be: each is drawn by an off-centre part of the
// view.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/passes/view/view.h"

namespace fire3dv::app {

// In pixels of the whole image, from its upper left corner.
struct ScreenshotTile {
  glm::uvec2 drawn_low{0}, drawn_size{0};  // the same size for all tiles of an image
  glm::uvec2 kept_low{0}, kept_size{0};    // the part that goes into the image
  bool operator==(const ScreenshotTile&) const = default;
};
// Pixels around the kept part: filters of the finished image, such as FXAA, read neighbours.
constexpr uint32_t kTileMargin_px = 32;

// One tile if the image has no side above max_side_px, which is more than twice the margin. The kept parts
// cover each pixel once, row by row.
std::vector<ScreenshotTile> screenshot_tiles(glm::uvec2 image_px, uint32_t max_side_px);

// The drawn part of the view of the whole image.
passes::View view_of_tile(const passes::View& whole, glm::uvec2 image_px, const ScreenshotTile& tile);

}  // namespace fire3dv::app
