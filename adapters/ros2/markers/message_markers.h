// Markers of ROS 2 messages: visualization_msgs/MarkerArray, sensor_msgs/PointCloud2, nav_msgs/Path and
// nav_msgs/OccupancyGrid as markers of the client (fire3dv/markers.h). Metres, frames as in REP 103. Messages
// are checked: an error names what is wrong and nothing is shown.
#pragma once

#include <fire3dv/markers.h>

#include <cstdint>
#include <string>
#include <vector>

#include "adapters/ros2/dds/topics.h"
#include "adapters/ros2/tf/frames.h"
#include "base/error.h"

namespace fire3dv::ros2 {

struct ShownMarker {
  std::string name;   // "TOPIC", or "TOPIC/NAMESPACE/ID"
  std::string frame;  // header.frame_id, without its leading slash
  Transform frame_from_marker;
  int32_t kind = FIRE3DV_MARKER_POINTS;
  float width_m = 0;
  uint64_t lifetime_ns = 0;
  bool is_frame_locked = false;         // follows its frame
  std::vector<float> positions, sizes;  // x y z each; one size, or one per position
  std::vector<uint8_t> colors;          // r g b a each, sRGB; one, or one per position
  std::vector<std::string> texts;       // of FIRE3DV_MARKER_TEXTS, one per position
};

enum class MarkerAction { set, clear, clear_all };
struct MarkerUpdate {
  MarkerAction action = MarkerAction::set;
  ShownMarker marker;  // of clear: the name alone
};

// Elements of one message at most.
constexpr size_t kMaxMarkerElements = 4'000'000;

// topic: without its leading slash.
Result<MarkerUpdate> update_of(const std::string& topic, const MarkerMessage& message);
// Points that are not finite are left out. Colours: the field rgb or rgba, else grey by the field intensity,
// else white.
Result<ShownMarker> marker_of(const std::string& topic, const PointCloudMessage& message);
// A line through the positions of the poses, which must have one frame.
Result<ShownMarker> marker_of(const std::string& topic, const PathMessage& message);
// Rectangles: dark where occupied (65 % and more), light where free (below 20 %), grey between; nothing where
// unknown.
Result<ShownMarker> marker_of(const std::string& topic, const MapMessage& message);

}  // namespace fire3dv::ros2
