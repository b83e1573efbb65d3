// Dock areas of the window: a column on the left, one on the right, a row at the bottom between them, and a
// splitter on the inner side of each. The uncovered rectangle between them belongs to the image. All areas
// together tile the window: no gap, no overlap. Pure functions, independent of ImGui.
#pragma once

#include <glm/glm.hpp>

#include "renderer/gui/gui.h"
#include "renderer/gui/layout_file.h"

namespace fire3dv::gui {

struct DockAreas {
  struct Area {
    Rect panels;    // empty if the dock is folded
    Rect splitter;  // the whole dock if it is folded
  };
  Area left, right, bottom;
  Rect image;  // may be empty in a window of a few pixels
};

// display_px: whole pixels. bottom_px: height that the contents of the bottom row need. In a small window the
// columns take at most 0.3 of the width each, the row at most 0.4 of the height.
DockAreas dock_areas(glm::vec2 display_px, float scale, const Layout& layout, float bottom_px);

}  // namespace fire3dv::gui
