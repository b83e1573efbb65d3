#include "renderer/gui/gizmo.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

namespace fire3dv::gui {
namespace {

constexpr float kAxisPt = 84, kRingPt = 68, kViewRingPt = 82, kPlanePt = 22, kPlaneSidePt = 14;
constexpr float kCentrePt = 7, kGrabPt = 7;
constexpr float kLeastFactor = 1e-3f, kMaxFactor = 1e3f;
constexpr float kPi = std::numbers::pi_v<float>;

float distance_to_segment(const glm::vec2& at, const glm::vec2& a, const glm::vec2& b) {
  const glm::vec2 way = b - a;
  const float squared = glm::dot(way, way);
  const float t = squared > 0 ? std::clamp(glm::dot(at - a, way) / squared, 0.0f, 1.0f) : 0;
  return glm::length(at - a - t * way);
}

float cross(const glm::vec2& a, const glm::vec2& b) {
  return a.x * b.y - a.y * b.x;
}

bool is_inside(const glm::vec2& at, const std::vector<glm::vec2>& quad) {
  bool left = false, right = false;
  for (size_t i = 0; i < quad.size(); ++i) {
    const float side = cross(quad[(i + 1) % quad.size()] - quad[i], at - quad[i]);
    left |= side < 0;
    right |= side > 0;
  }
  return !(left && right);
}

float snapped(float value, float step) {
  return std::round(value / step) * step;
}

}  // namespace

std::optional<glm::vec2> GizmoView::pixel_of(const glm::vec3& world) const {
  const glm::vec4 clip = view.clip_from_world * glm::vec4(world, 1);
  if (!(clip.w > 1e-9f) || clip.z > clip.w) return std::nullopt;  // depth 1 is the near plane
  return low_px + (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * size_px;
}

glm::vec2 GizmoView::pixels_per_metre(const glm::vec3& world, const glm::vec3& direction) const {
  const glm::vec4 clip = view.clip_from_world * glm::vec4(world, 1);
  const glm::vec4 step = view.clip_from_world * glm::vec4(direction, 0);
  return (glm::vec2(step) * clip.w - glm::vec2(clip) * step.w) / (clip.w * clip.w) * 0.5f * size_px;
}

GizmoView::Ray GizmoView::ray_through(const glm::vec2& px) const {
  const glm::vec2 ndc = (px - low_px) / size_px * 2.0f - 1.0f;
  if (!view.orthographic) {
    return {view.eye_world, glm::normalize(view.world_from_ndc_x * ndc.x + view.world_from_ndc_y * ndc.y +
                                           view.world_from_ndc_origin)};
  }
  const glm::dvec4 at = glm::inverse(glm::dmat4(view.clip_from_world)) * glm::dvec4(ndc, 0.5, 1);
  return {glm::vec3(glm::dvec3(at) / at.w), view.look_world};
}

glm::vec3 GizmoView::right_world() const {
  const glm::vec3 up = std::abs(view.look_world.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
  return glm::normalize(glm::cross(view.look_world, up));
}

glm::vec3 GizmoView::look_at(const glm::vec3& world) const {
  return view.orthographic ? view.look_world : glm::normalize(world - view.eye_world);
}

void Gizmo::place(const GizmoView& view, const glm::mat4& world_from_node, app::GizmoTool tool, bool is_local,
                  float points) {
  handles_.clear();
  view_ = view;
  tool_ = tool;
  points_ = points;
  world_from_node_ = world_from_node;
  origin_ = world_from_node[3];
  const std::optional<glm::vec2> centre = view.pixel_of(origin_);
  if (!centre || tool == app::GizmoTool::none) return;
  centre_px_ = *centre;
  axes_ = {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)};
  for (int axis = 0; axis < 3 && (is_local || tool == app::GizmoTool::scale); ++axis) {
    const glm::vec3 column = world_from_node[axis];
    if (const float length = glm::length(column); length > 0)
      axes_[static_cast<size_t>(axis)] = column / length;
  }
  const float pixels = glm::length(view.pixels_per_metre(origin_, view.right_world()));
  if (!(pixels > 0) || !std::isfinite(pixels)) return;
  length_m_ = kAxisPt * points / pixels;
  if (tool == app::GizmoTool::rotate) {
    add_rings(points);
  } else {
    handles_.push_back({GizmoHandle::Kind::centre, 3, {centre_px_}});
    if (tool == app::GizmoTool::move) add_planes(points);
    add_axes(points);
  }
}

// An axis that points at the eye is too short to be grabbed.
bool Gizmo::is_seen(int axis) const {
  const glm::vec3& direction = axes_[static_cast<size_t>(axis)];
  return glm::length(view_.pixels_per_metre(origin_, direction)) * length_m_ > 0.2f * kAxisPt * points_;
}

void Gizmo::add_axes(float points) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!is_seen(axis)) continue;
    const glm::vec3& direction = axes_[static_cast<size_t>(axis)];
    const std::optional<glm::vec2> tip = view_.pixel_of(origin_ + direction * length_m_);
    if (!tip) continue;
    const glm::vec2 way = *tip - centre_px_;
    const float length = std::max(glm::length(way), 1.0f);
    handles_.push_back({GizmoHandle::Kind::axis,
                        axis,
                        {centre_px_ + way * std::min(kCentrePt * points / length, 0.5f), *tip}});
  }
}

void Gizmo::add_planes(float points) {
  (void)points;
  for (int axis = 0; axis < 3; ++axis) {
    const glm::vec3& normal = axes_[static_cast<size_t>(axis)];
    if (std::abs(glm::dot(normal, view_.look_at(origin_))) < 0.2f) continue;
    const glm::vec3 a = axes_[static_cast<size_t>((axis + 1) % 3)],
                    b = axes_[static_cast<size_t>((axis + 2) % 3)];
    const float near = length_m_ * kPlanePt / kAxisPt, far = length_m_ * (kPlanePt + kPlaneSidePt) / kAxisPt;
    GizmoHandle plane{GizmoHandle::Kind::plane, axis, {}};
    for (const auto& [u, v] :
         {std::pair(near, near), std::pair(far, near), std::pair(far, far), std::pair(near, far)}) {
      if (const auto corner = view_.pixel_of(origin_ + a * u + b * v)) plane.outline.push_back(*corner);
    }
    if (plane.outline.size() == 4) handles_.push_back(std::move(plane));
  }
}

// Rings show the half that faces the camera.
void Gizmo::add_rings(float points) {
  constexpr int kSteps = 72;
  const glm::vec3 look = view_.look_at(origin_);
  for (int axis = 0; axis < 3; ++axis) {
    const glm::vec3& normal = axes_[static_cast<size_t>(axis)];
    const glm::vec3 a = axes_[static_cast<size_t>((axis + 1) % 3)];
    const glm::vec3 u = glm::normalize(a - normal * glm::dot(a, normal)), v = glm::cross(normal, u);
    const float radius = length_m_ * kRingPt / kAxisPt;
    const bool is_whole = std::abs(glm::dot(normal, look)) > 0.98f;
    // Begins at the point that is farthest from the camera, so that the visible part is one chain.
    const float begin = std::atan2(glm::dot(v, look), glm::dot(u, look));
    GizmoHandle ring{GizmoHandle::Kind::ring, axis, {}};
    for (int i = 0; i <= kSteps; ++i) {
      const float angle = begin + 2 * kPi * static_cast<float>(i) / kSteps;
      const glm::vec3 way = u * std::cos(angle) + v * std::sin(angle);
      if (!is_whole && glm::dot(way, look) > 0.05f) continue;
      if (const auto px = view_.pixel_of(origin_ + way * radius)) ring.outline.push_back(*px);
    }
    if (ring.outline.size() > 2) handles_.push_back(std::move(ring));
  }
  GizmoHandle ring{GizmoHandle::Kind::ring, 3, {}};
  for (int i = 0; i <= kSteps; ++i) {
    const float angle = 2 * kPi * static_cast<float>(i) / kSteps;
    ring.outline.push_back(centre_px_ + glm::vec2(std::cos(angle), std::sin(angle)) * kViewRingPt * points);
  }
  handles_.push_back(std::move(ring));
}

std::optional<size_t> Gizmo::hit(const glm::vec2& cursor) const {
  std::optional<size_t> nearest;
  float best = kGrabPt * points_;
  for (size_t i = 0; i < handles_.size(); ++i) {
    const GizmoHandle& handle = handles_[i];
    if (handle.kind == GizmoHandle::Kind::centre && glm::length(cursor - centre_px_) < kCentrePt * points_)
      return i;
    if (handle.kind == GizmoHandle::Kind::plane && is_inside(cursor, handle.outline)) return i;
    if (handle.kind == GizmoHandle::Kind::centre || handle.kind == GizmoHandle::Kind::plane) continue;
    for (size_t p = 0; p + 1 < handle.outline.size(); ++p) {
      const float distance = distance_to_segment(cursor, handle.outline[p], handle.outline[p + 1]);
      if (distance >= best) continue;
      best = distance;
      nearest = i;
    }
  }
  return nearest;
}

bool Gizmo::is_dragged(const GizmoHandle& handle) const {
  return dragged_ && dragged_->kind == handle.kind && dragged_->axis == handle.axis;
}

float Gizmo::snap_m() const {
  return std::pow(10.0f, std::floor(std::log10(std::max(length_m_, 1e-9f) / 2)));
}

// Distance from the origin of the point on the axis that is nearest to the cursor's ray.
float Gizmo::along_axis(const glm::vec3& axis, const glm::vec2& px) const {
  const GizmoView::Ray ray = view_.ray_through(px);
  const glm::dvec3 a(axis), d(ray.direction), w = glm::dvec3(origin_) - glm::dvec3(ray.origin);
  const double b = glm::dot(a, d), denominator = 1 - b * b;
  if (denominator < 1e-9) return 0;
  return static_cast<float>((b * glm::dot(d, w) - glm::dot(a, w)) / denominator);
}

std::optional<glm::vec3> Gizmo::on_plane(const glm::vec3& normal, const glm::vec2& px) const {
  const GizmoView::Ray ray = view_.ray_through(px);
  const double across = glm::dot(glm::dvec3(normal), glm::dvec3(ray.direction));
  if (std::abs(across) < 1e-6) return std::nullopt;
  const double t = glm::dot(glm::dvec3(normal), glm::dvec3(origin_) - glm::dvec3(ray.origin)) / across;
  if (!view_.view.orthographic && t <= 0) return std::nullopt;  // beyond the horizon
  return glm::vec3(glm::dvec3(ray.origin) + t * glm::dvec3(ray.direction));
}

void Gizmo::begin(size_t index, const glm::vec2& px) {
  const GizmoHandle& handle = handles_.at(index);
  Drag drag;
  drag.tool = tool_;
  drag.kind = handle.kind;
  drag.axis = handle.axis;
  drag.world_from_node = world_from_node_;
  drag.grabbed_px = px;
  const glm::vec3 look = view_.look_at(origin_);
  drag.axis_world = handle.axis < 3 ? axes_[static_cast<size_t>(handle.axis)] : -look;
  drag.normal_world = handle.axis < 3 ? drag.axis_world : view_.view.look_world;
  drag.grabbed = along_axis(drag.axis_world, px);
  drag.grabbed_world = on_plane(drag.normal_world, px).value_or(origin_);
  drag.last_rad = angle_at(drag, px);
  dragged_ = drag;
  value_ = tool_ == app::GizmoTool::scale ? 1 : 0;
}

glm::mat4 Gizmo::drag(const glm::vec2& px, bool snaps) {
  if (!dragged_) return world_from_node_;
  // The geometry of the drag is that of its begin, even if a camera moves meanwhile.
  origin_ = dragged_->world_from_node[3];
  switch (dragged_->tool) {
    case app::GizmoTool::move:
      return translated(px, snaps);
    case app::GizmoTool::rotate:
      return rotated(px, snaps);
    case app::GizmoTool::scale:
      return scaled(px, snaps);
    case app::GizmoTool::none:
      break;
  }
  return dragged_->world_from_node;
}

glm::mat4 Gizmo::translated(const glm::vec2& px, bool snaps) {
  const Drag& drag = *dragged_;
  glm::vec3 way(0);
  if (drag.kind == GizmoHandle::Kind::axis) {
    float distance = along_axis(drag.axis_world, px) - drag.grabbed;
    if (snaps) distance = snapped(distance, snap_m());
    way = drag.axis_world * distance;
    value_ = distance;
  } else {
    const std::optional<glm::vec3> at = on_plane(drag.normal_world, px);
    if (!at) return world_from_node_;
    way = *at - drag.grabbed_world;
    if (snaps) {
      glm::vec3 steps(0);
      for (const glm::vec3& axis : axes_) steps += axis * snapped(glm::dot(way, axis), snap_m());
      way = steps;
    }
    value_ = glm::length(way);
  }
  glm::mat4 moved = drag.world_from_node;
  moved[3] += glm::vec4(way, 0);
  return moved;
}

// Of the cursor about the axis. A ring that is seen from its edge follows the cursor along its tangent.
float Gizmo::angle_at(const Drag& drag, const glm::vec2& px) const {
  const glm::vec3 look = view_.look_at(origin_);
  const float facing = glm::dot(drag.axis_world, look);
  if (std::abs(facing) < 0.05f) {
    const glm::vec3 tangent = glm::cross(drag.axis_world, -look);
    const glm::vec2 way = view_.pixels_per_metre(origin_, tangent) * (length_m_ * kRingPt / kAxisPt);
    const float squared = glm::dot(way, way);
    return squared > 0 ? glm::dot(px - drag.grabbed_px, way) / squared : 0;
  }
  const std::optional<glm::vec3> at = on_plane(drag.axis_world, px);
  if (!at) return drag.last_rad;
  const glm::vec3 helper = std::abs(drag.axis_world.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  const glm::vec3 u = glm::normalize(glm::cross(drag.axis_world, helper)), v = glm::cross(drag.axis_world, u);
  const glm::vec3 arm = *at - origin_;
  return std::atan2(glm::dot(arm, v), glm::dot(arm, u));
}

glm::mat4 Gizmo::rotated(const glm::vec2& px, bool snaps) {
  Drag& drag = *dragged_;
  const float angle = angle_at(drag, px);
  drag.turned_rad += std::remainder(angle - drag.last_rad, 2 * kPi);
  drag.last_rad = angle;
  value_ = snaps ? snapped(drag.turned_rad, kSnapRad) : drag.turned_rad;
  const glm::mat4 turn = glm::rotate(glm::mat4(1), value_, drag.axis_world);
  glm::mat4 turned = turn * drag.world_from_node;
  turned[3] = drag.world_from_node[3];
  return turned;
}

glm::mat4 Gizmo::scaled(const glm::vec2& px, bool snaps) {
  const Drag& drag = *dragged_;
  float factor = 1;
  if (drag.kind == GizmoHandle::Kind::axis) {
    if (std::abs(drag.grabbed) > 0) factor = along_axis(drag.axis_world, px) / drag.grabbed;
  } else {  // right and up enlarge
    const glm::vec2 way = (px - drag.grabbed_px) / (kAxisPt * points_);
    factor = std::exp2(way.x - way.y);
  }
  if (snaps) factor = snapped(factor, kSnapScale);
  value_ = std::isfinite(factor) ? std::clamp(factor, kLeastFactor, kMaxFactor) : 1;
  glm::vec3 factors(value_);
  if (drag.kind == GizmoHandle::Kind::axis) {
    factors = glm::vec3(1);
    factors[drag.axis] = value_;
  }
  return glm::scale(drag.world_from_node, factors);
}

}  // namespace fire3dv::gui
