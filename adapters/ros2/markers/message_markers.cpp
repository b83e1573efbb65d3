// Markers of visualization_msgs/MarkerArray.
#include "adapters/ros2/markers/message_markers.h"

#include <optional>

#include "adapters/ros2/markers/message_values.h"

namespace fire3dv::ros2 {
namespace {

constexpr size_t kMaxNameBytes = 200;

// Shape of a marker message.
struct Shape {
  int32_t kind;
  bool takes_points;   // positions are `points`; otherwise one element at the pose
  bool has_size;       // scale is the extent; otherwise scale.x is the width, except of triangles
  uint32_t group = 1;  // points of an element
};
std::optional<Shape> shape_of(const MarkerMessage& message) {
  switch (message.type) {
    case 1:
      return Shape{FIRE3DV_MARKER_BOXES, false, true};
    case 2:
      return Shape{FIRE3DV_MARKER_SPHERES, false, true};
    case 3:
      return Shape{FIRE3DV_MARKER_CYLINDERS, false, true};
    case 4:
      return Shape{FIRE3DV_MARKER_LINE_STRIP, true, false};
    case 5:
      return Shape{FIRE3DV_MARKER_LINES, true, false, 2};
    case 6:
      return Shape{FIRE3DV_MARKER_BOXES, true, true};
    case 7:
      return Shape{FIRE3DV_MARKER_SPHERES, true, true};
    case 8:
      return Shape{FIRE3DV_MARKER_POINTS, true, false};
    case 11:
      return Shape{FIRE3DV_MARKER_TRIANGLES, true, false, 3};
    default:
      return std::nullopt;
  }
}

// An arrow by two points with the diameter of its shaft in scale.x, or along x of the pose with length
// scale.x and diameter scale.y.
Result<void> add_arrow(const MarkerMessage& message, ShownMarker& marker) {
  marker.kind = FIRE3DV_MARKER_ARROWS;
  if (message.points._length >= 2) {
    for (uint32_t i = 0; i < 2; ++i) {
      const auto& point = message.points._buffer[i];
      append(marker.positions, point.x, point.y, point.z);
    }
    marker.width_m = static_cast<float>(message.scale.x);
    return {};
  }
  if (message.points._length != 0) return Error{"an arrow has no or two points"};
  append(marker.positions, 0, 0, 0);
  append(marker.positions, message.scale.x, 0, 0);
  marker.width_m = static_cast<float>(message.scale.y);
  return {};
}

// The scale's z is the height of a capital A.
Result<void> add_text(const MarkerMessage& message, ShownMarker& marker) {
  constexpr double kCapitalHeight = 0.729;  // of the renderer's font, in units of its size
  marker.kind = FIRE3DV_MARKER_TEXTS;
  marker.width_m = static_cast<float>(message.scale.z / kCapitalHeight);
  append(marker.positions, 0, 0, 0);
  marker.texts = {message.text ? message.text : ""};
  return {};
}

// Points, and their colours: one each, or one for each group of triangles.
Result<void> add_points(const MarkerMessage& message, const Shape& shape,
                        const geometry_msgs_msg_dds__Vector3_& scale, ShownMarker& marker) {
  const uint32_t count = message.points._length, colors = message.colors._length;
  if (count > kMaxMarkerElements) return Error{"it has " + std::to_string(count) + " points"};
  if (count % shape.group != 0)
    return Error{"it has " + std::to_string(count) + " points, not groups of " + std::to_string(shape.group)};
  const bool has_colors = count > 0 && colors == count;
  const bool has_face_colors = count > 0 && shape.group == 3 && colors == count / 3;
  for (uint32_t i = 0; i < count; ++i) {
    const auto& point = message.points._buffer[i];
    append(marker.positions, scale.x * point.x, scale.y * point.y, scale.z * point.z);
    if (has_colors) append(marker.colors, message.colors._buffer[i]);
    if (has_face_colors) append(marker.colors, message.colors._buffer[i / 3]);
  }
  return {};
}

Result<void> add_elements(const MarkerMessage& message, const Shape& shape, ShownMarker& marker) {
  marker.kind = shape.kind;
  if (shape.kind == FIRE3DV_MARKER_TRIANGLES) {  // scale multiplies their points
    if (message.scale.x == 0 || message.scale.y == 0 || message.scale.z == 0)
      return Error{"a scale of 0 is invisible; triangles have a scale of 1 in x, y and z"};
    return add_points(message, shape, message.scale, marker);
  }
  if (shape.has_size)
    marker.sizes = {static_cast<float>(message.scale.x), static_cast<float>(message.scale.y),
                    static_cast<float>(message.scale.z)};
  else
    marker.width_m = static_cast<float>(message.scale.x);
  if (shape.takes_points) return add_points(message, shape, {1, 1, 1}, marker);
  append(marker.positions, 0, 0, 0);
  return {};
}

}  // namespace

Result<MarkerUpdate> update_of(const std::string& topic, const MarkerMessage& message) {
  MarkerUpdate update;
  ShownMarker& marker = update.marker;
  const std::string ns = message.ns ? message.ns : "";
  marker.name = topic + "/" + ns + (ns.empty() ? "" : "/") + std::to_string(message.id);
  if (marker.name.size() > kMaxNameBytes) return Error{"its namespace is too long"};
  if (message.action == 2 || message.action == 3) {
    update.action = message.action == 2 ? MarkerAction::clear : MarkerAction::clear_all;
    return update;
  }
  if (message.action != 0) return Error{"its action " + std::to_string(message.action) + " is unknown"};
  const Result<Transform> pose = transform_of_pose(message.pose);
  if (!pose) return pose.error();
  for (const double side : {message.scale.x, message.scale.y, message.scale.z})
    if (!is_coordinate(side) || side < 0) return Error{"its scale is negative or not finite"};
  marker.frame = frame_of(message.header);
  marker.frame_from_marker = *pose;
  marker.is_frame_locked = message.frame_locked;
  if (message.lifetime.sec > 0 || (message.lifetime.sec == 0 && message.lifetime.nanosec > 0))
    marker.lifetime_ns =
        static_cast<uint64_t>(message.lifetime.sec) * 1'000'000'000 + message.lifetime.nanosec;
  constexpr int32_t kArrow = 0, kText = 9, kMesh = 10;
  const std::optional<Shape> shape = shape_of(message);
  if (message.type != kArrow && message.type != kText && !shape)
    return Error{message.type == kMesh ? "meshes are not shown"
                                       : "its type " + std::to_string(message.type) + " is unknown"};
  const Result<void> added = message.type == kArrow  ? add_arrow(message, marker)
                             : message.type == kText ? add_text(message, marker)
                                                     : add_elements(message, *shape, marker);
  if (!added) return added.error();
  for (const float value : marker.positions)
    if (!is_coordinate(value)) return Error{"a point is not finite"};
  if (marker.colors.empty()) append(marker.colors, message.color);
  return update;
}

}  // namespace fire3dv::ros2
