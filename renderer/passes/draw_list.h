// The draws of a scene, collected from its nodes and sorted by pipeline state, material and primitive, so
// that the GPU changes state as seldom as can be. No Vulkan: tested without a GPU.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/scene.h"

namespace fire3dv::passes {

struct Draw {
  uint32_t node = 0;
  uint32_t primitive = 0;
};

// Draws that share all state.
struct DrawBin {
  scene::Topology topology = scene::Topology::triangles;
  scene::AlphaMode alpha_mode = scene::AlphaMode::opaque;
  bool double_sided = false;
  bool mirrored = false;  // the node's transform turns triangles inside out
  uint32_t first_draw = 0;
  uint32_t draw_count = 0;

  bool blended() const { return alpha_mode == scene::AlphaMode::blend; }
  // What only the raster pipeline draws.
  bool on_top() const { return blended() || topology != scene::Topology::triangles; }
};

struct DrawList {
  std::vector<Draw> draws;
  std::vector<DrawBin> bins;  // opaque, then mask, then blend; of each triangles, lines, points

  // mirrored: for each node, whether its transform has a negative determinant. hidden: for each node, or
  // empty where none is.
  static DrawList collect(const scene::Scene& scene, const std::vector<bool>& mirrored,
                          const std::vector<bool>& hidden = {});
};

}  // namespace fire3dv::passes
