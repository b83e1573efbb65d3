#include "renderer/window/overlay_markers.h"

#include <array>
#include <cmath>
#include <utility>

#include "renderer/window/guides.h"
#include "renderer/window/measurement.h"
#include "renderer/window/overlay_colors.h"

namespace fire3dv::app {
namespace {

using wire::Marker;
using wire::MarkerKind;

// Keys of markers.
constexpr uint64_t kMeasuredPath = 0, kMeasuredLine = 1, kMeasuredPoints = 2, kMeasuredText = 3;

constexpr uint64_t kSpringLine = 4, kSpringEnds = 5;
constexpr uint64_t kGrid = 16, kFrusta = 1024;  // the first of each
constexpr uint64_t kMarkersPerFrustum = 2;
constexpr uint32_t kMeasureColor = marker_color(0xffc040);
constexpr uint32_t kSpringColor = marker_color(0x40ff80);

// As passes::make_view() takes the pose of a camera.
glm::mat4 without_scale(glm::mat4 world_from_camera) {
  for (int axis = 0; axis < 3; ++axis) {
    const float length = glm::length(glm::vec3(world_from_camera[axis]));
    if (length > 0) world_from_camera[axis] /= length;
  }
  return world_from_camera;
}

}  // namespace

const std::vector<state::ShownMarker>& OverlayMarkers::update(const ViewState& view_state,
                                                              const ImageView& seen) {
  last_ = std::exchange(known_, {});
  shown_.clear();
  if (view_state.shows_grid) {
    uint64_t key = kGrid;
    for (Marker& marker : ground_grid(seen.scene, seen.display_scale)) add(key++, std::move(marker));
  }
  if (view_state.shows_frusta) add_frusta(view_state, seen);
  if (view_state.measures) add_measurement(view_state, seen.poses, seen.display_scale);
  if (view_state.spring) add_spring(*view_state.spring, seen.display_scale);
  return shown_;
}

// Of a dragged body: from the grabbed point to where it is pulled.
void OverlayMarkers::add_spring(const std::array<glm::vec3, 2>& ends, float display_scale) {
  Marker marker;
  marker.flags = wire::kMarkerOverlaid;
  marker.kind = MarkerKind::lines;
  marker.width = 3 * display_scale;
  marker.positions = {marker_point(ends[0]), marker_point(ends[1])};
  marker.colors = {kSpringColor};
  add(kSpringLine, marker);
  marker.kind = MarkerKind::points;
  marker.width = 10 * display_scale;
  add(kSpringEnds, std::move(marker));
}

// Without the camera of the image, whose frustum is the image's border.
void OverlayMarkers::add_frusta(const ViewState& view_state, const ImageView& seen) {
  if (listed_scene_ != seen.scene_number) {
    listed_scene_ = seen.scene_number;
    cameras_ = scene::camera_nodes(seen.scene);  // visits every node
    if (cameras_.size() > kMaxFrusta) cameras_.resize(kMaxFrusta);
  }
  const float depth_m = frustum_depth_m(seen.scene);
  uint64_t key = kFrusta;
  for (const uint32_t node : cameras_) {
    const uint64_t first = std::exchange(key, key + kMarkersPerFrustum);
    if (node == seen.camera_node || seen.edits.is_hidden(node)) continue;
    const scene::Camera* const edited = seen.edits.camera_at(node);
    const scene::Camera& camera = edited ? *edited : seen.scene.cameras[seen.scene.nodes[node].camera];
    const glm::mat4 world_from_camera = without_scale(seen.poses.world_from_node(node));
    uint64_t of_frustum = first;
    for (Marker& marker : camera_frustum(camera, seen.scene.nodes[node].name, depth_m, seen.image_aspect,
                                         node == view_state.selected, seen.display_scale))
      add(of_frustum++, std::move(marker), world_from_camera);
  }
}

void OverlayMarkers::add(uint64_t key, Marker marker, const glm::mat4& world_from_marker) {
  SentMarker known;
  const auto last = last_.find(key);
  if (last != last_.end() && *last->second.marker == marker) {
    known = last->second;
  } else {
    known = {++last_id_, std::make_shared<const Marker>(std::move(marker))};
  }
  shown_.push_back({known.id, known.marker, world_from_marker});
  known_.emplace(key, std::move(known));
}

// The line between the points, the way along the world's axes, and the distance above its middle.
void OverlayMarkers::add_measurement(const ViewState& view_state, const state::PoseState& poses,
                                     float display_scale) {
  std::vector<glm::vec3> points;
  for (const SurfacePoint& point : view_state.measured) points.push_back(position_world(point, poses));
  if (points.empty()) return;
  Marker marker;
  marker.flags = wire::kMarkerOverlaid;
  if (points.size() == 2) {
    const glm::vec3 from = points[0], to = points[1];
    const std::array<glm::vec3, 4> path{from, {to.x, from.y, from.z}, {to.x, to.y, from.z}, to};
    marker.kind = MarkerKind::lines;
    marker.width = 1.5f * display_scale;
    for (size_t axis = 0; axis < 3; ++axis) {
      for (const size_t end : {axis, axis + 1}) {
        marker.positions.push_back(marker_point(path[end]));
        marker.colors.push_back(kAxisColors[axis]);
      }
    }
    add(kMeasuredPath, marker);
    marker.width = 2.5f * display_scale;
    marker.positions = {marker_point(from), marker_point(to)};
    marker.colors = {kMeasureColor};
    add(kMeasuredLine, marker);
    Marker text = marker;
    text.kind = MarkerKind::texts;
    text.width = 15 * display_scale;
    text.positions = {marker_point(0.5f * (from + to))};
    text.texts = {metres_text(glm::distance(from, to)) + "\n"};  // the empty line lifts it above the middle
    add(kMeasuredText, std::move(text));
  }
  marker.kind = MarkerKind::points;
  marker.width = 9 * display_scale;
  marker.colors = {kMeasureColor};
  marker.positions.clear();
  for (const glm::vec3& point : points) marker.positions.push_back(marker_point(point));
  add(kMeasuredPoints, std::move(marker));
}

}  // namespace fire3dv::app
