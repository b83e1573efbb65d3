#include "adapters/ros2/markers/marker_input.h"

#include <utility>

#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr int kMaxMarkerBatches = 16;  // of one topic, before poses are published

void refuse(const MarkerContext& context, const std::string& topic, const char* what, const Error& reason) {
  context.warn("markers of /" + topic, "/" + topic + ": " + what + " is not shown: " + reason.message);
}

}  // namespace

template <typename Message>
Result<void> MarkerInput::open_topics(const Participant& participant, const Names& names,
                                      const std::vector<std::string>& wanted, Profile profile,
                                      std::vector<Topic<Message>>& topics) {
  for (const std::string& topic : wanted) {
    if (!is_valid_name(topic)) return Error{quote(topic) + " is not a name of a topic"};
    const std::string name = names.resolve(topic);
    auto reader = Reader<Message>::open(participant, name, profile);
    if (!reader) return reader.error();
    topics.push_back({name.substr(1), std::move(*reader)});
  }
  return {};
}

Result<std::unique_ptr<MarkerInput>> MarkerInput::open(const Participant& participant, const Names& names,
                                                       const MarkerTopics& topics) {
  auto input = std::make_unique<MarkerInput>();
  if (auto done = open_topics(participant, names, topics.markers, Profile::markers, input->markers_); !done)
    return done.error();
  if (auto done = open_topics(participant, names, topics.points, Profile::points, input->points_); !done)
    return done.error();
  if (auto done = open_topics(participant, names, topics.paths, Profile::path, input->paths_); !done)
    return done.error();
  if (auto done = open_topics(participant, names, topics.maps, Profile::map, input->maps_); !done)
    return done.error();
  return input;
}

std::vector<WatchedTopic> MarkerInput::topics() const {
  std::vector<WatchedTopic> all;
  const auto add = [&](const auto& topics, const char* type) {
    for (const auto& topic : topics) all.push_back({"/" + topic.name, type, topic.reader.get()});
  };
  add(markers_, "visualization_msgs/msg/MarkerArray");
  add(points_, "sensor_msgs/msg/PointCloud2");
  add(paths_, "nav_msgs/msg/Path");
  add(maps_, "nav_msgs/msg/OccupancyGrid");
  return all;
}

template <typename Message>
void MarkerInput::take_single(std::vector<Topic<Message>>& topics, const MarkerContext& context) {
  for (Topic<Message>& topic : topics) {
    topic.reader.take([&](const Message& message, const dds_sample_info_t&) {
      Result<ShownMarker> marker = marker_of(topic.name, message);
      if (marker)
        store_.set(topic.name, std::move(*marker), context);
      else
        refuse(context, topic.name, "the message", marker.error());
    });
  }
}

void MarkerInput::take_one(const std::string& topic, const MarkerMessage& message,
                           const MarkerContext& context) {
  Result<MarkerUpdate> update = update_of(topic, message);
  if (!update) return refuse(context, topic, "a marker", update.error());
  switch (update->action) {
    case MarkerAction::set:
      return store_.set(topic, std::move(update->marker), context);
    case MarkerAction::clear:
      return store_.clear(topic, update->marker.name, context);
    case MarkerAction::clear_all:
      return store_.clear_topic(topic, context);
  }
}

void MarkerInput::take(const MarkerContext& context) {
  store_.update(context);
  for (Topic<MarkerArrayMessage>& topic : markers_) {
    const auto take_all = [&](const MarkerArrayMessage& message, const dds_sample_info_t&) {
      for (uint32_t i = 0; i < message.markers._length; ++i)
        take_one(topic.name, message.markers._buffer[i], context);
    };
    for (int batch = 0; batch < kMaxMarkerBatches && topic.reader.take(take_all) > 0; ++batch) {
    }
  }
  take_single(points_, context);
  take_single(paths_, context);
  take_single(maps_, context);
}

}  // namespace fire3dv::ros2
