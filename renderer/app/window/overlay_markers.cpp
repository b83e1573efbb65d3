#include "renderer/app/window/overlay_markers.h"

#include <array>
#include <cmath>
#include <utility>

#include "renderer/app/window/measurement.h"

namespace fire3dv::app {
namespace {

using wire::Marker;
using wire::MarkerKind;

// Keys of markers.
constexpr uint64_t kMeasuredPath = 0, kMeasuredLine = 1, kMeasuredPoints = 2, kMeasuredText = 3;

constexpr uint32_t rgb(uint32_t hex, uint32_t alpha = 0xff) {
  return (hex >> 16 & 0xff) | (hex & 0xff00) | (hex & 0xff) << 16 | alpha << 24;
}
constexpr std::array<uint32_t, 3> kAxisColors{rgb(0xe0483e), rgb(0x4fb04a), rgb(0x3f7fe0)};
constexpr uint32_t kMeasureColor = rgb(0xffc040);

std::array<float, 3> floats(const glm::vec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace

const std::vector<state::ShownMarker>& OverlayMarkers::update(const gui::Viewer& viewer,
                                                              const state::PoseState& poses,
                                                              float display_scale) {
  last_ = std::exchange(known_, {});
  shown_.clear();
  if (viewer.measures) add_measurement(viewer, poses, display_scale);
  return shown_;
}

void OverlayMarkers::add(uint64_t key, Marker marker, const glm::mat4& world_from_marker) {
  Known known;
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
void OverlayMarkers::add_measurement(const gui::Viewer& viewer, const state::PoseState& poses,
                                     float display_scale) {
  std::vector<glm::vec3> points;
  for (const gui::SurfacePoint& point : viewer.measured) points.push_back(position_world(point, poses));
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
        marker.positions.push_back(floats(path[end]));
        marker.colors.push_back(kAxisColors[axis]);
      }
    }
    add(kMeasuredPath, marker);
    marker.width = 2.5f * display_scale;
    marker.positions = {floats(from), floats(to)};
    marker.colors = {kMeasureColor};
    add(kMeasuredLine, marker);
    Marker text = marker;
    text.kind = MarkerKind::texts;
    text.width = 15 * display_scale;
    text.positions = {floats(0.5f * (from + to))};
    text.texts = {metres_text(glm::distance(from, to)) + "\n"};  // the empty line lifts it above the middle
    add(kMeasuredText, std::move(text));
  }
  marker.kind = MarkerKind::points;
  marker.width = 9 * display_scale;
  marker.colors = {kMeasureColor};
  marker.positions.clear();
  for (const glm::vec3& point : points) marker.positions.push_back(floats(point));
  add(kMeasuredPoints, std::move(marker));
}

}  // namespace fire3dv::app
