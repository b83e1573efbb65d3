#include "renderer/window/measurement.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace fire3dv::app {
namespace {

std::string vector_text(const glm::vec3& v) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.5g %.5g %.5g", static_cast<double>(v.x),
                static_cast<double>(v.y), static_cast<double>(v.z));
  return text.data();
}

bool is_finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

std::string metres_text(float metres) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.5g m", static_cast<double>(metres));
  return text.data();
}

SurfacePoint surface_point(const passes::Picked& picked) {
  if (!picked.world_from_node) return {scene::kNone, picked.position_world};
  const glm::dmat4 node_from_world = glm::inverse(glm::dmat4(*picked.world_from_node));
  const glm::vec3 position_node(node_from_world * glm::dvec4(picked.position_world, 1));
  if (!is_finite(position_node)) return {scene::kNone, picked.position_world};
  return {picked.node, position_node};
}

std::optional<std::string> take_pick(ViewState& view_state, const passes::Picked& picked,
                                     const state::PoseState& poses) {
  const bool is_surface = picked.node < poses.node_drives().size();
  if (!view_state.measures) {
    view_state.selected = is_surface ? picked.node : scene::kNone;
    view_state.picked_point.reset();
    if (is_surface) view_state.picked_point = surface_point(picked);
    return std::nullopt;
  }
  if (!is_surface) return std::nullopt;
  if (view_state.measured.size() >= 2) view_state.measured.clear();
  view_state.measured.push_back(surface_point(picked));
  if (view_state.measured.size() < 2) return std::nullopt;
  const glm::vec3 from = position_world(view_state.measured[0], poses),
                  to = position_world(view_state.measured[1], poses);
  return "distance " + metres_text(glm::distance(from, to)) + " from " + vector_text(from) + " to " +
         vector_text(to) + "; along x y z: " + vector_text(to - from);
}

}  // namespace fire3dv::app
