#include "adapters/ros2/markers/marker_input.h"

#include <array>
#include <utility>

#include "protocol/base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr int kMaxBatches = 16;       // of one topic, before poses are published
constexpr size_t kMaxShown = 20'000;  // markers of one topic

void warn(LimitedLog& log, const std::string& topic, const std::string& what, const std::string& reason) {
  log.warn("markers of /" + topic, "/" + topic + ": " + what + " is not shown: " + reason);
}

}  // namespace

template <typename Message>
Result<void> MarkerInput::open_topics(const Participant& participant, const Names& names,
                                      const std::vector<std::string>& wanted, Profile profile,
                                      std::vector<Topic<Message>>& topics) {
  for (const std::string& topic : wanted) {
    if (!is_valid_name(topic)) return Error{quote(topic) + " is no name of a topic"};
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

std::vector<dds_entity_t> MarkerInput::readers() const {
  std::vector<dds_entity_t> all;
  for (const auto& topic : markers_) all.push_back(topic.reader.get());
  for (const auto& topic : points_) all.push_back(topic.reader.get());
  for (const auto& topic : paths_) all.push_back(topic.reader.get());
  for (const auto& topic : maps_) all.push_back(topic.reader.get());
  return all;
}

void MarkerInput::set(const std::string& topic, const ShownMarker& marker, const Place& place,
                      const Show& show, LimitedLog& log) {
  const std::string what = marker.name == topic ? "the message" : "marker " + quote(marker.name);
  const Transform* const fixed_from_frame = place(marker.frame);
  if (!fixed_from_frame)
    return warn(log, topic, what, "frame " + quote(marker.frame) + " is not connected to the fixed frame");
  std::set<std::string>& shown = shown_[topic];
  if (!shown.contains(marker.name) && shown.size() >= kMaxShown)
    return warn(log, topic, what, "the topic has " + std::to_string(kMaxShown) + " markers already");
  const std::array<float, 12> pose = matrix_of(*fixed_from_frame * marker.frame_from_marker);
  fire3dv_marker sent = {};
  sent.struct_size = sizeof sent;
  sent.kind = marker.kind;
  sent.width_unit = FIRE3DV_MARKER_LENGTHS;
  sent.width = marker.width_m;
  sent.lifetime_ns = marker.lifetime_ns;
  sent.parent_from_marker = pose.data();
  sent.positions = marker.positions.data();
  sent.position_count = marker.positions.size() / 3;
  sent.sizes = marker.sizes.empty() ? nullptr : marker.sizes.data();
  sent.size_count = marker.sizes.size() / 3;
  sent.colors = marker.colors.data();
  sent.color_count = marker.colors.size() / 4;
  if (const Result<void> done = show(marker.name, &sent); !done)
    return warn(log, topic, what, done.error().message);
  shown.insert(marker.name);
}

void MarkerInput::clear(const std::string& topic, const std::string& name, const Show& show,
                        LimitedLog& log) {
  if (const Result<void> done = show(name, nullptr); !done)
    warn(log, topic, "the end of " + quote(name), done.error().message);
}

template <typename Message>
void MarkerInput::take_single(std::vector<Topic<Message>>& topics, const Place& place, const Show& show,
                              LimitedLog& log) {
  for (Topic<Message>& topic : topics) {
    topic.reader.take([&](const Message& message, const dds_sample_info_t&) {
      const Result<ShownMarker> marker = marker_of(topic.name, message);
      if (marker)
        set(topic.name, *marker, place, show, log);
      else
        warn(log, topic.name, "the message", marker.error().message);
    });
  }
}

void MarkerInput::take(const Place& place, const Show& show, LimitedLog& log) {
  for (Topic<MarkerArrayMessage>& topic : markers_) {
    std::set<std::string>& shown = shown_[topic.name];
    const auto take_one = [&](const MarkerMessage& message) {
      const Result<MarkerUpdate> update = update_of(topic.name, message);
      if (!update) return warn(log, topic.name, "a marker", update.error().message);
      if (update->action == MarkerAction::set) return set(topic.name, update->marker, place, show, log);
      if (update->action == MarkerAction::clear) {
        if (shown.erase(update->marker.name) != 0) clear(topic.name, update->marker.name, show, log);
        return;
      }
      for (const std::string& name : std::exchange(shown, {})) clear(topic.name, name, show, log);
    };
    const auto take_all = [&](const MarkerArrayMessage& message, const dds_sample_info_t&) {
      for (uint32_t i = 0; i < message.markers._length; ++i) take_one(message.markers._buffer[i]);
    };
    for (int batch = 0; batch < kMaxBatches && topic.reader.take(take_all) > 0; ++batch) {
    }
  }
  take_single(points_, place, show, log);
  take_single(paths_, place, show, log);
  take_single(maps_, place, show, log);
}

}  // namespace fire3dv::ros2
