// What a viewer wants of an image beyond the scene: another look at it, an outline around what is selected,
// and to know what lies at a pixel. All of it comes from the visibility buffer: what is blended or drawn as
// lines and points is looked through.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>

#include "renderer/passes/debug_view.h"
#include "renderer/scene/scene.h"

namespace fire3dv::passes {

struct Pick {
  uint32_t x = 0, y = 0;  // pixel, from the upper left corner
  uint64_t tag = 0;       // comes back with what was found
  bool operator==(const Pick&) const = default;
};

struct Picked {
  uint64_t tag = 0;
  uint32_t node = scene::kNone;  // of the scene that was set then; kNone: the background
  glm::vec3 position_world{0};
  float depth_m = 0;  // along the look; infinite for the background
};

// Of one image.
struct Inspection {
  DebugView debug_view = DebugView::none;
  uint32_t selected = scene::kNone;  // node that is outlined, with all below it
  std::optional<Pick> pick;

  bool any() const { return debug_view != DebugView::none || selected != scene::kNone || pick; }
};

}  // namespace fire3dv::passes
