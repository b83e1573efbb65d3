#include "adapters/ros2/markers/message_markers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

namespace fire3dv::ros2 {
namespace {

using Color = std::array<uint8_t, 4>;
constexpr size_t kMaxNameBytes = 200;
constexpr double kMaxCoordinate = 1e9;  // metres

bool is_coordinate(double value) {
  return std::isfinite(value) && std::abs(value) <= kMaxCoordinate;
}

std::string frame_of(const std_msgs_msg_dds__Header_& header) {
  const std::string frame = header.frame_id ? header.frame_id : "";
  return frame.starts_with('/') ? frame.substr(1) : frame;
}

// A quaternion of zeros is no rotation, as in rviz.
Result<Transform> transform_of_pose(const geometry_msgs_msg_dds__Pose_& pose) {
  Transform transform{{pose.position.x, pose.position.y, pose.position.z},
                      {pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w}};
  for (const double value : transform.translation)
    if (!is_coordinate(value)) return Error{"its position is not finite"};
  double length = 0;
  for (const double value : transform.rotation) length += value * value;
  if (!std::isfinite(length)) return Error{"its orientation is not finite"};
  transform.rotation = length < 1e-12 ? std::array<double, 4>{0, 0, 0, 1} : normalized(transform.rotation);
  return transform;
}

uint8_t byte_of(float share) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(std::isfinite(share) ? share : 0.0f, 0.0f, 1.0f)));
}
void append(std::vector<uint8_t>& colors, const std_msgs_msg_dds__ColorRGBA_& color) {
  for (const float share : {color.r, color.g, color.b, color.a}) colors.push_back(byte_of(share));
}
void append(std::vector<float>& positions, double x, double y, double z) {
  for (const double value : {x, y, z}) positions.push_back(static_cast<float>(value));
}

// Shape of a marker message.
struct Shape {
  int32_t kind;
  bool takes_points;   // positions are `points`; otherwise one element at the pose
  bool has_size;       // scale is the extent; otherwise scale.x is the width
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

Result<void> add_elements(const MarkerMessage& message, const Shape& shape, ShownMarker& marker) {
  marker.kind = shape.kind;
  if (shape.has_size)
    marker.sizes = {static_cast<float>(message.scale.x), static_cast<float>(message.scale.y),
                    static_cast<float>(message.scale.z)};
  else
    marker.width_m = static_cast<float>(message.scale.x);
  if (!shape.takes_points) {
    append(marker.positions, 0, 0, 0);
    return {};
  }
  const uint32_t count = message.points._length;
  if (count > kMaxMarkerElements) return Error{"it has " + std::to_string(count) + " points"};
  if (count % shape.group != 0)
    return Error{"it has " + std::to_string(count) + " points, not groups of " + std::to_string(shape.group)};
  const bool has_colors = count > 0 && message.colors._length == count;
  for (uint32_t i = 0; i < count; ++i) {
    const auto& point = message.points._buffer[i];
    append(marker.positions, point.x, point.y, point.z);
    if (has_colors) append(marker.colors, message.colors._buffer[i]);
  }
  return {};
}

// Reader of one field of a point cloud.
struct FieldReader {
  uint32_t offset = 0;
  uint8_t datatype = 0;  // 2 uint8, 4 uint16, 6 uint32, 7 float32, 8 float64
  size_t bytes() const { return datatype == 8 ? 8 : datatype >= 5 ? 4 : datatype >= 3 ? 2 : 1; }
  double read(const uint8_t* point) const {
    const auto value = [&]<typename T>(T number) {
      std::memcpy(&number, point + offset, sizeof number);
      return static_cast<double>(number);
    };
    switch (datatype) {
      case 1:
        return value(int8_t{});
      case 2:
        return value(uint8_t{});
      case 3:
        return value(int16_t{});
      case 4:
        return value(uint16_t{});
      case 5:
        return value(int32_t{});
      case 6:
        return value(uint32_t{});
      case 7:
        return value(float{});
      default:
        return value(double{});
    }
  }
};

std::optional<FieldReader> field_named(const PointCloudMessage& message, const char* name) {
  for (uint32_t i = 0; i < message.fields._length; ++i) {
    const auto& field = message.fields._buffer[i];
    if (!field.name || std::strcmp(field.name, name) != 0 || field.datatype < 1 || field.datatype > 8)
      continue;
    const FieldReader reader{field.offset, field.datatype};
    if (uint64_t{field.offset} + reader.bytes() <= message.point_step) return reader;
  }
  return std::nullopt;
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
  if (message.lifetime.sec > 0 || (message.lifetime.sec == 0 && message.lifetime.nanosec > 0))
    marker.lifetime_ns =
        static_cast<uint64_t>(message.lifetime.sec) * 1'000'000'000 + message.lifetime.nanosec;
  const std::optional<Shape> shape = shape_of(message);
  if (message.type != 0 && !shape)
    return Error{message.type == 9    ? "texts are not shown"
                 : message.type == 10 ? "meshes are not shown"
                                      : "its type " + std::to_string(message.type) + " is unknown"};
  const Result<void> added =
      message.type == 0 ? add_arrow(message, marker) : add_elements(message, *shape, marker);
  if (!added) return added.error();
  for (const float value : marker.positions)
    if (!is_coordinate(value)) return Error{"a point is not finite"};
  if (marker.colors.empty()) append(marker.colors, message.color);
  return update;
}

Result<ShownMarker> marker_of(const std::string& topic, const PointCloudMessage& message) {
  if (message.is_bigendian) return Error{"its numbers are big-endian"};
  const auto x = field_named(message, "x"), y = field_named(message, "y"), z = field_named(message, "z");
  if (!x || !y || !z) return Error{"it has no fields x, y and z within a point"};
  const uint64_t count = uint64_t{message.width} * message.height;
  if (count > kMaxMarkerElements) return Error{"it has " + std::to_string(count) + " points"};
  const uint64_t row_bytes = uint64_t{message.width} * message.point_step;
  if (message.height > 1 && message.row_step < row_bytes) return Error{"its row_step is smaller than a row"};
  const uint64_t needed = count == 0 ? 0 : uint64_t{message.height - 1} * message.row_step + row_bytes;
  if (needed > message.data._length)
    return Error{"it has " + std::to_string(message.data._length) + " bytes of " + std::to_string(needed)};
  auto packed = field_named(message, "rgb");
  const bool has_alpha = !packed && field_named(message, "rgba");
  if (has_alpha) packed = field_named(message, "rgba");
  if (packed && packed->bytes() != 4) packed.reset();
  const auto intensity = packed ? std::nullopt : field_named(message, "intensity");
  ShownMarker marker;
  marker.name = topic;
  marker.frame = frame_of(message.header);
  marker.width_m = 0.02f;
  marker.positions.reserve(3 * count);
  std::vector<double> levels;
  for (uint32_t row = 0; row < message.height; ++row) {
    for (uint32_t column = 0; column < message.width; ++column) {
      const uint8_t* const point =
          message.data._buffer + uint64_t{row} * message.row_step + uint64_t{column} * message.point_step;
      const double at[] = {x->read(point), y->read(point), z->read(point)};
      if (!is_coordinate(at[0]) || !is_coordinate(at[1]) || !is_coordinate(at[2])) continue;
      append(marker.positions, at[0], at[1], at[2]);
      if (packed) {
        const uint8_t* const bgra = point + packed->offset;
        marker.colors.insert(marker.colors.end(),
                             {bgra[2], bgra[1], bgra[0], has_alpha ? bgra[3] : uint8_t{255}});
      } else if (intensity) {
        levels.push_back(intensity->read(point));
      }
    }
  }
  if (intensity) {
    double low = INFINITY, high = -INFINITY;
    for (const double level : levels)
      if (std::isfinite(level)) low = std::min(low, level), high = std::max(high, level);
    for (const double level : levels) {
      const double share = high > low && std::isfinite(level) ? (level - low) / (high - low) : 1;
      const uint8_t grey = byte_of(static_cast<float>(0.2 + 0.8 * share));
      marker.colors.insert(marker.colors.end(), {grey, grey, grey, 255});
    }
  }
  if (marker.colors.empty()) marker.colors = {255, 255, 255, 255};
  return marker;
}

Result<ShownMarker> marker_of(const std::string& topic, const PathMessage& message) {
  ShownMarker marker;
  marker.name = topic;
  marker.kind = FIRE3DV_MARKER_LINE_STRIP;
  marker.frame = frame_of(message.header);
  marker.width_m = 0.03f;
  marker.colors = {25, 255, 0, 255};  // rviz's default
  if (message.poses._length > kMaxMarkerElements) return Error{"it has too many poses"};
  for (uint32_t i = 0; i < message.poses._length; ++i) {
    const auto& pose = message.poses._buffer[i];
    const std::string frame = frame_of(pose.header);
    if (!frame.empty() && frame != marker.frame)
      return Error{"its poses have the frames " + marker.frame + " and " + frame};
    const auto& [px, py, pz] = pose.pose.position;
    if (!is_coordinate(px) || !is_coordinate(py) || !is_coordinate(pz)) return Error{"a pose is not finite"};
    append(marker.positions, px, py, pz);
  }
  if (marker.positions.size() < 6) marker.positions.clear();  // no line
  return marker;
}

Result<ShownMarker> marker_of(const std::string& topic, const MapMessage& message) {
  const auto& info = message.info;
  const Result<Transform> origin = transform_of_pose(info.origin);
  if (!origin) return Error{"its origin: " + origin.error().message};
  if (!(info.resolution > 0) || !is_coordinate(info.resolution))
    return Error{"its resolution is not positive"};
  if (uint64_t{info.width} * info.height != message.data._length)
    return Error{"it has " + std::to_string(message.data._length) + " cells, not " +
                 std::to_string(info.width) + " x " + std::to_string(info.height)};
  ShownMarker marker;
  marker.name = topic;
  marker.kind = FIRE3DV_MARKER_TRIANGLES;
  marker.frame = frame_of(message.header);
  marker.frame_from_marker = *origin;
  const auto color_at = [&](uint32_t row, uint32_t column) -> std::optional<Color> {
    const int value = static_cast<int8_t>(message.data._buffer[uint64_t{row} * info.width + column]);
    if (value < 0 || value > 100) return std::nullopt;
    if (value >= 65) return Color{30, 30, 30, 255};
    return value < 20 ? Color{230, 230, 230, 255} : Color{130, 130, 130, 255};
  };
  const double cell = info.resolution;
  for (uint32_t row = 0; row < info.height; ++row) {
    for (uint32_t column = 0; column < info.width;) {
      const std::optional<Color> color = color_at(row, column);
      const uint32_t begin = column;
      while (column < info.width && color_at(row, column) == color) ++column;
      if (!color) continue;
      if (marker.positions.size() / 3 + 6 > kMaxMarkerElements) return Error{"it has too many runs of cells"};
      const double left = begin * cell, right = column * cell, low = row * cell, high = (row + 1) * cell;
      for (const auto& [px, py] : {std::pair(left, low), std::pair(right, low), std::pair(right, high),
                                   std::pair(left, low), std::pair(right, high), std::pair(left, high)}) {
        append(marker.positions, px, py, 0);
        marker.colors.insert(marker.colors.end(), color->begin(), color->end());
      }
    }
  }
  if (marker.colors.empty()) marker.colors = {255, 255, 255, 255};
  return marker;
}

}  // namespace fire3dv::ros2
