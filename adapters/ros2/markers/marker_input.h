// Marker topics of the bridge: readers of MarkerArray, PointCloud2, Path and OccupancyGrid, whose markers a
// store shows.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "adapters/ros2/dds/discovery.h"
#include "adapters/ros2/dds/names.h"
#include "adapters/ros2/dds/participant.h"
#include "adapters/ros2/dds/topics.h"
#include "adapters/ros2/markers/marker_store.h"
#include "base/error.h"

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

  // Topics whose readers to wait for.
  std::vector<WatchedTopic> topics() const;

  // Updates the store and takes the messages that have arrived, 16 batches of a topic at most. Call it often:
  // lifetimes end and frames appear without a message. What is not shown is reported, with topic and reason.
  void take(const MarkerContext& context);

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
  void take_single(std::vector<Topic<Message>>& topics, const MarkerContext& context);
  void take_one(const std::string& topic, const MarkerMessage& message, const MarkerContext& context);

  std::vector<Topic<MarkerArrayMessage>> markers_;
  std::vector<Topic<PointCloudMessage>> points_;
  std::vector<Topic<PathMessage>> paths_;
  std::vector<Topic<MapMessage>> maps_;
  MarkerStore store_;
};

}  // namespace fire3dv::ros2
