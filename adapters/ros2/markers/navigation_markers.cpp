// Markers of nav_msgs/Path and nav_msgs/OccupancyGrid.
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "adapters/ros2/markers/message_markers.h"
#include "adapters/ros2/markers/message_values.h"

namespace fire3dv::ros2 {
namespace {

using Color = std::array<uint8_t, 4>;

}  // namespace

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
  const uint32_t rows = info.width == 0 ? 0 : info.height;  // rows without cells may be billions
  for (uint32_t row = 0; row < rows; ++row) {
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
