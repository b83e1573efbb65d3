// Inspection requests of a viewer for an image: debug view, outline of the selected node, and picking. They
// use the visibility buffer, so blended surfaces, lines and points are ignored.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>

#include "renderer/scene/model/scene.h"
#include "renderer/settings/debug_view.h"

namespace fire3dv::passes {

struct Pick {
  uint32_t x = 0, y = 0;  // pixel, from the upper left corner
  uint64_t tag = 0;       // returned with the result
  bool operator==(const Pick&) const = default;
};

struct Picked {
  uint64_t tag = 0;
  uint32_t node = scene::kNone;  // of the scene that was set at the time; kNone: the background
  glm::vec3 position_world{0};
  float depth_m = 0;  // along the view direction; infinite for the background
  // Of the picked image. Empty: the surface does not move with the node, because joints move it.
  std::optional<glm::mat4> world_from_node = glm::mat4(1);
};

// Requests for one image.
struct Inspection {
  settings::DebugView debug_view = settings::DebugView::none;
  uint32_t selected = scene::kNone;  // outlined node, including its descendants
  std::optional<Pick> pick;

  bool any() const { return debug_view != settings::DebugView::none || selected != scene::kNone || pick; }
};

}  // namespace fire3dv::passes
