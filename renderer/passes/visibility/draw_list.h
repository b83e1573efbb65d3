// Draw list of a scene, sorted by pipeline state, material and primitive to minimise state changes. It has no
// Vulkan dependency, so that tests need no GPU.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/model/scene.h"

namespace fire3dv::passes {

struct Draw {
  uint32_t node = 0;
  uint32_t primitive = 0;
};

// Draws with equal pipeline state.
struct DrawBin {
  scene::Topology topology = scene::Topology::triangles;
  scene::AlphaMode alpha_mode = scene::AlphaMode::opaque;
  bool double_sided = false;
  bool mirrored = false;  // negative determinant: flips the winding
  uint32_t first_draw = 0;
  uint32_t draw_count = 0;

  bool blended() const { return alpha_mode == scene::AlphaMode::blend; }
  // Forward-only: the compute rasteriser cannot draw it.
  bool is_forward_only() const { return blended() || topology != scene::Topology::triangles; }
};

struct DrawList {
  std::vector<Draw> draws;
  std::vector<DrawBin> bins;  // opaque, then mask, then blend; in each: triangles, lines, points

  // mirrored: per node, true for a negative determinant. hidden: per node, or empty if none is hidden.
  static DrawList collect(const scene::Scene& scene, const std::vector<bool>& mirrored,
                          const std::vector<bool>& hidden = {});
};

}  // namespace fire3dv::passes
