#include "renderer/window/screenshots/screenshot_tiles.h"

#include <algorithm>

namespace fire3dv::app {
namespace {

struct Span {
  uint32_t drawn_low, drawn_size, kept_low, kept_size;
};

// Along one axis.
std::vector<Span> spans(uint32_t image_px, uint32_t max_side_px) {
  if (image_px <= max_side_px) return {{0, image_px, 0, image_px}};
  const uint32_t max_kept_px = max_side_px - 2 * kTileMargin_px;
  std::vector<Span> found;
  for (uint32_t low = 0; low < image_px; low += max_kept_px) {
    const uint32_t margin_low = low - std::min(low, kTileMargin_px);
    found.push_back({std::min(margin_low, image_px - max_side_px), max_side_px, low,
                     std::min(max_kept_px, image_px - low)});
  }
  return found;
}

}  // namespace

std::vector<ScreenshotTile> screenshot_tiles(glm::uvec2 image_px, uint32_t max_side_px) {
  std::vector<ScreenshotTile> tiles;
  for (const Span& y : spans(image_px.y, max_side_px)) {
    for (const Span& x : spans(image_px.x, max_side_px)) {
      tiles.push_back({{x.drawn_low, y.drawn_low},
                       {x.drawn_size, y.drawn_size},
                       {x.kept_low, y.kept_low},
                       {x.kept_size, y.kept_size}});
    }
  }
  return tiles;
}

passes::View view_of_tile(const passes::View& whole, glm::uvec2 image_px, const ScreenshotTile& tile) {
  if (tile.drawn_size == image_px) return whole;
  // whole_ndc = center + share * tile_ndc, in double precision: tiles must meet.
  const glm::dvec2 image(image_px), size(tile.drawn_size);
  const glm::dvec2 share = size / image;
  const glm::dvec2 center = (2.0 * glm::dvec2(tile.drawn_low) + size) / image - 1.0;
  glm::dmat4 tile_from_whole(1);
  tile_from_whole[0][0] = 1 / share.x;
  tile_from_whole[1][1] = 1 / share.y;
  tile_from_whole[3][0] = -center.x / share.x;
  tile_from_whole[3][1] = -center.y / share.y;
  passes::View view = whole;
  view.clip_from_world = glm::mat4(tile_from_whole * glm::dmat4(whole.clip_from_world));
  view.world_from_ndc_origin = whole.world_from_ndc_origin +
                               static_cast<float>(center.x) * whole.world_from_ndc_x +
                               static_cast<float>(center.y) * whole.world_from_ndc_y;
  view.world_from_ndc_x = static_cast<float>(share.x) * whole.world_from_ndc_x;
  view.world_from_ndc_y = static_cast<float>(share.y) * whole.world_from_ndc_y;
  view.off_centre = !whole.orthographic;
  return view;
}

}  // namespace fire3dv::app
