// Markers of sensor_msgs/PointCloud2.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "adapters/ros2/markers/message_markers.h"
#include "adapters/ros2/markers/message_values.h"

namespace fire3dv::ros2 {
namespace {

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

Result<ShownMarker> marker_of(const std::string& topic, const PointCloudMessage& message) {
  ShownMarker marker;
  marker.name = topic;
  marker.frame = frame_of(message.header);
  marker.width_m = 0.02f;
  if (message.width == 0 || message.height == 0) {  // rows without points may be billions
    marker.colors = {255, 255, 255, 255};
    return marker;
  }
  if (message.is_bigendian) return Error{"its numbers are big-endian"};
  const auto x = field_named(message, "x"), y = field_named(message, "y"), z = field_named(message, "z");
  if (!x || !y || !z) return Error{"it has no fields x, y and z within a point"};
  const uint64_t count = uint64_t{message.width} * message.height;
  if (count > kMaxMarkerElements) return Error{"it has " + std::to_string(count) + " points"};
  const uint64_t row_bytes = uint64_t{message.width} * message.point_step;
  if (message.height > 1 && message.row_step < row_bytes) return Error{"its row_step is smaller than a row"};
  const uint64_t needed = uint64_t{message.height - 1} * message.row_step + row_bytes;
  if (needed > message.data._length)
    return Error{"it has " + std::to_string(message.data._length) + " bytes of " + std::to_string(needed)};
  auto packed = field_named(message, "rgb");
  const bool has_alpha = !packed && field_named(message, "rgba");
  if (has_alpha) packed = field_named(message, "rgba");
  if (packed && packed->bytes() != 4) packed.reset();
  const auto intensity = packed ? std::nullopt : field_named(message, "intensity");
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

}  // namespace fire3dv::ros2
