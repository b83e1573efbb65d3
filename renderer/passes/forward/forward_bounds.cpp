#include "renderer/passes/forward/forward_bounds.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace fire3dv::passes {
namespace {

constexpr float kMarginPixels = 4;  // covers line and point sizes, and rounding

struct Bounds {
  glm::vec2 low{1e30f}, high{-1e30f};  // pixels
};

// Returns false if part of the box cannot be projected.
bool add_box(const glm::mat4& clip_from_node, const scene::Primitive& primitive, const glm::vec2& size,
             Bounds& bounds) {
  glm::vec2 low(1e30f), high(-1e30f);
  int behind_near = 0, in_front = 0;
  for (int i = 0; i < 8; ++i) {
    const glm::vec3 corner(i & 1 ? primitive.bounds_max.x : primitive.bounds_min.x,
                           i & 2 ? primitive.bounds_max.y : primitive.bounds_min.y,
                           i & 4 ? primitive.bounds_max.z : primitive.bounds_min.z);
    const glm::vec4 clip = clip_from_node * glm::vec4(corner, 1);
    const bool is_behind = !(clip.w > 0) || clip.z > clip.w;
    ++(is_behind ? behind_near : in_front);
    if (is_behind) continue;
    const glm::vec2 pixel = (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * size;
    low = glm::min(low, pixel);
    high = glm::max(high, pixel);
  }
  if (in_front == 0) return true;  // outside of the view
  if (behind_near != 0 || !std::isfinite(low.x + low.y + high.x + high.y)) return false;
  bounds.low = glm::min(bounds.low, low);
  bounds.high = glm::max(bounds.high, high);
  return true;
}

}  // namespace

VkRect2D forward_bounds(const GpuScene& gpu_scene, const scene::Scene& scene, const state::PoseState& poses,
                        const View& view, VkExtent2D extent) {
  const VkRect2D whole{{0, 0}, extent};
  const glm::vec2 size(extent.width, extent.height);
  Bounds bounds;
  for (const DrawBin& bin : gpu_scene.draw_list.bins) {
    if (!bin.is_forward_only()) continue;
    for (uint32_t i = bin.first_draw; i < bin.first_draw + bin.draw_count; ++i) {
      const Draw& draw = gpu_scene.draw_list.draws[i];
      // A shift means per-instance vertices or an edited colour.
      if (gpu_scene.primitive_shift_of_node[draw.node] != 0) return whole;
      const glm::mat4 clip_from_node = view.clip_from_world * poses.world_from_node(draw.node);
      if (!add_box(clip_from_node, scene.primitives[draw.primitive], size, bounds)) return whole;
    }
  }
  const glm::vec2 low = glm::clamp(glm::floor(bounds.low - kMarginPixels), glm::vec2(0), size);
  const glm::vec2 high = glm::clamp(glm::ceil(bounds.high + kMarginPixels), glm::vec2(0), size);
  if (!(low.x < high.x && low.y < high.y)) return {{0, 0}, {0, 0}};
  return {{static_cast<int32_t>(low.x), static_cast<int32_t>(low.y)},
          {static_cast<uint32_t>(high.x - low.x), static_cast<uint32_t>(high.y - low.y)}};
}

}  // namespace fire3dv::passes
