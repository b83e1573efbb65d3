// Marker topics of the bridge: readers of MarkerArray, PointCloud2, Path and OccupancyGrid, and what is shown
// of them.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "adapters/ros2/dds/names.h"
#include "adapters/ros2/dds/participant.h"
#include "adapters/ros2/dds/topics.h"
#include "adapters/ros2/limited_log.h"
#include "adapters/ros2/markers/message_markers.h"
#include "protocol/base/error.h"

namespace fire3dv::ros2 {

// Topics by command line; relative names are resolved.
struct MarkerTopics {
  std::vector<std::string> markers, points, paths, maps;
  bool is_empty() const { return markers.empty() && points.empty() && paths.empty() && maps.empty(); }
};

class MarkerInput {
 public:
  static Result<std::unique_ptr<MarkerInput>> open(const Participant& participant, const Names& names,
                                                   const MarkerTopics& topics);

  // Readers to wait for.
  std::vector<dds_entity_t> readers() const;

  // fixed_from_frame of a frame now; null: it has no path to the fixed frame.
  using Place = std::function<const Transform*(const std::string& frame)>;
  // Sets a marker, or clears it (null), in all renderers.
  using Show = std::function<Result<void>(const std::string& name, const fire3dv_marker* marker)>;
  // Takes the messages that have arrived, 16 of a topic at most. Markers are placed where their frame is at
  // that time. What is not shown is reported by `log`, with topic and reason.
  void take(const Place& place, const Show& show, LimitedLog& log);

 private:
  template <typename Message>
  struct Topic {
    std::string name;  // without its leading slash
    Reader<Message> reader;
  };
  template <typename Message>
  static Result<void> open_topics(const Participant& participant, const Names& names,
                                  const std::vector<std::string>& wanted, Profile profile,
                                  std::vector<Topic<Message>>& topics);
  template <typename Message>
  void take_single(std::vector<Topic<Message>>& topics, const Place& place, const Show& show,
                   LimitedLog& log);
  void set(const std::string& topic, const ShownMarker& marker, const Place& place, const Show& show,
           LimitedLog& log);
  void clear(const std::string& topic, const std::string& name, const Show& show, LimitedLog& log);

  std::vector<Topic<MarkerArrayMessage>> markers_;
  std::vector<Topic<PointCloudMessage>> points_;
  std::vector<Topic<PathMessage>> paths_;
  std::vector<Topic<MapMessage>> maps_;
  std::map<std::string, std::set<std::string>> shown_;  // names, by topic
};

}  // namespace fire3dv::ros2
