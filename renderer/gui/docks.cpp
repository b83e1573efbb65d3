#include "renderer/gui/docks.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::gui {
namespace {

constexpr float kSplitterPt = 7, kFoldedPt = 14;
constexpr float kMaxColumnShare = 0.3f, kMaxRowShare = 0.4f;

float pixels(float pt, float scale) {
  return std::max(std::round(pt * scale), 1.0f);
}

}  // namespace

DockAreas dock_areas(glm::vec2 display, float scale, const Layout& layout, float bottom_px) {
  const auto is_folded = [&](Dock dock) { return layout.is_folded(dock); };
  const auto column = [&](float pt, Dock dock) {
    return std::min(pixels(is_folded(dock) ? kFoldedPt : pt, scale),
                    std::max(std::floor(display.x * kMaxColumnShare), 1.0f));
  };
  // A splitter leaves room for panels, if there is any.
  const auto splitter = [&](float dock_px, Dock dock) {
    return is_folded(dock) ? dock_px : std::min(pixels(kSplitterPt, scale), std::floor(dock_px / 2));
  };
  const float left = std::min(column(layout.left_pt, Dock::left), display.x);
  const float right = std::min(column(layout.right_pt, Dock::right), display.x - left);
  const float wanted =
      is_folded(Dock::bottom) ? pixels(kFoldedPt, scale) : std::ceil(bottom_px) + pixels(kSplitterPt, scale);
  const float bottom = std::min(wanted, std::max(std::floor(display.y * kMaxRowShare), 1.0f));

  const float x0 = left, x1 = display.x - right, y1 = display.y - bottom;
  const float left_bar = splitter(left, Dock::left), right_bar = splitter(right, Dock::right),
              bottom_bar = splitter(bottom, Dock::bottom);
  DockAreas areas;
  areas.left = {{{0, 0}, {x0 - left_bar, display.y}}, {{x0 - left_bar, 0}, {x0, display.y}}};
  areas.right = {{{x1 + right_bar, 0}, display}, {{x1, 0}, {x1 + right_bar, display.y}}};
  areas.bottom = {{{x0, y1 + bottom_bar}, {x1, display.y}}, {{x0, y1}, {x1, y1 + bottom_bar}}};
  areas.image = {{x0, 0}, {x1, y1}};
  return areas;
}

}  // namespace fire3dv::gui
