#include "renderer/window/body_drag.h"

#include <cmath>
#include <utility>

#include "base/text.h"

namespace fire3dv::app {
namespace {

template <typename Affine>
glm::dmat4 matrix_of(const Affine& affine) {
  glm::dmat4 matrix(1);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      matrix[column][row] = static_cast<double>(affine.m[static_cast<size_t>(row * 4 + column)]);
  return matrix;
}

glm::dmat4 world_from_body(const state::Stream& stream, uint32_t node) {
  return matrix_of(stream.world_from_stream) * matrix_of(stream.poses[node]);
}

bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

bool BodyDrag::is_possible() const {
  for (const state::StreamId id : router_.streams())
    if (poses_.streams()[id].inputs().find(wire::InputKind::drag)) return true;
  return false;
}

const state::Stream* BodyDrag::stream_of_held() const {
  const state::Stream* const stream = held_ ? router_.find(held_->epoch) : nullptr;
  return stream && held_->node < stream->poses.size() ? stream : nullptr;
}

bool BodyDrag::act(wire::InputAction action) const {
  const state::Stream* const stream = stream_of_held();
  if (!stream) return false;
  wire::InputEvent event;
  event.input = held_->input;
  event.action = action;
  event.node = held_->node;
  event.node_point = {held_->point_body.x, held_->point_body.y, held_->point_body.z};
  const glm::dvec3 target(glm::inverse(matrix_of(stream->world_from_stream)) *
                          glm::dvec4(held_->target_world, 1));
  if (!is_finite(target)) return false;
  event.target = {target.x, target.y, target.z};
  return router_.act(held_->epoch, kWindow, std::move(event));
}

std::optional<std::string> BodyDrag::grab(const passes::Picked& picked) {
  if (!is_pressed_ || held_) return {};
  const auto& drives = poses_.node_drives();
  if (picked.node >= drives.size()) return {};
  const state::NodeDrive& drive = drives[picked.node];
  if (drive.stream >= poses_.streams().size()) return "nothing drags this node: no simulator moves it";
  const state::Stream& stream = poses_.streams()[drive.stream];
  const auto* const drag = router_.find(stream.epoch) ? stream.inputs().find(wire::InputKind::drag) : nullptr;
  if (!drag) return "stream " + quote(stream.name) + " does not let its bodies be dragged";
  if (drive.pose_index >= stream.poses.size()) return {};
  const glm::dvec3 point(picked.position_world);
  const glm::dvec3 point_body(glm::inverse(world_from_body(stream, drive.pose_index)) * glm::dvec4(point, 1));
  if (!is_finite(point_body)) return {};
  held_ = Held{stream.epoch, drag->first, drive.pose_index, point_body, point};
  if (!act(wire::InputAction::begin)) held_.reset();
  return {};
}

void BodyDrag::move(glm::vec2 cursor_ndc, const passes::View& view) {
  if (!held_) return;
  const glm::dmat4 clip_from_world(view.clip_from_world);
  const glm::dvec4 clip = clip_from_world * glm::dvec4(held_->target_world, 1);
  if (!(clip.w > 0)) return;  // behind the camera
  const glm::dvec4 moved =
      glm::inverse(clip_from_world) *
      glm::dvec4(double{cursor_ndc.x} * clip.w, double{cursor_ndc.y} * clip.w, clip.z, clip.w);
  const glm::dvec3 target = glm::dvec3(moved) / moved.w;
  if (!is_finite(target) || target == held_->target_world) return;
  held_->target_world = target;
  (void)act(wire::InputAction::move);
}

void BodyDrag::release() {
  is_pressed_ = false;
  if (held_) (void)act(wire::InputAction::end);
  held_.reset();
}

std::optional<std::array<glm::vec3, 2>> BodyDrag::ends() const {
  const state::Stream* const stream = stream_of_held();
  if (!stream) return {};
  const glm::dvec3 from(world_from_body(*stream, held_->node) * glm::dvec4(held_->point_body, 1));
  return std::array{glm::vec3(from), glm::vec3(held_->target_world)};
}

}  // namespace fire3dv::app
