#include "tests/conformance/json_message.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "tests/conformance/json_edit.h"
#include "tests/conformance/json_image.h"

namespace fire3dv::conformance {
namespace {

using Json = nlohmann::ordered_json;

Json matrices_to_json(std::span<const wire::Affine3x4> matrices) {
  Json result = Json::array();
  for (const wire::Affine3x4& matrix : matrices) result.push_back(matrix.m);
  return result;
}

std::vector<wire::Affine3x4> matrices_from_json(const Json& json) {
  std::vector<wire::Affine3x4> result;
  for (const Json& matrix : json) result.push_back({matrix.get<std::array<float, 12>>()});
  return result;
}

Json to_json_of(const wire::StreamDescription& m) {
  return {{"type", "StreamDescription"},
          {"protocol_major", m.protocol_major},
          {"protocol_minor", m.protocol_minor},
          {"epoch", m.epoch},
          {"adapter_name", m.adapter_name},
          {"node_names", m.node_names},
          {"world_from_stream", m.world_from_stream.m},
          {"body_from_node", matrices_to_json(m.body_from_node)},
          {"nominal_rate_hz", m.nominal_rate_hz},
          {"scene_uri", m.scene_uri},
          {"clock",
           {{"boot_id", m.clock.boot_id},
            {"monotonic_at_open_ns", m.clock.monotonic_at_open_ns},
            {"realtime_at_open_ns", m.clock.realtime_at_open_ns},
            {"sim_seconds_per_second", m.clock.sim_seconds_per_second}}}};
}

Json to_json_of(const wire::PoseFrameView& m) {
  Json json{{"type", "PoseFrame"},
            {"epoch", m.header.epoch},
            {"sequence", m.header.sequence},
            {"sim_time_ns", m.header.sim_time_ns},
            {"publish_time_ns", m.header.publish_time_ns},
            {"scene_version", m.header.scene_version},
            {"flags", m.header.flags},
            {"node_count", m.node_count},
            {"first_node", m.first_node},
            {"poses", matrices_to_json(m.poses)}};
  if (!m.node_indices.empty())
    json["node_indices"] = std::vector<uint32_t>(m.node_indices.begin(), m.node_indices.end());
  return json;
}

Json to_json_of(const wire::Welcome& m) {
  return {{"type", "Welcome"},
          {"status", static_cast<uint8_t>(m.status)},
          {"protocol_major", m.protocol_major},
          {"protocol_minor", m.protocol_minor},
          {"epoch", m.epoch},
          {"renderer_name", m.renderer_name},
          {"message", m.message},
          {"unmatched_names", m.unmatched_names},
          {"conflicting_names", m.conflicting_names}};
}

Json to_json_of(const wire::Ack& m) {
  return {{"type", "Ack"}, {"epoch", m.epoch}, {"sequence", m.sequence}};
}

Json to_json_of(const wire::Ping& m) {
  return {{"type", "Ping"}, {"id", m.id}, {"sender_time_ns", m.sender_time_ns}};
}

Json to_json_of(const wire::Pong& m) {
  return {{"type", "Pong"},
          {"id", m.id},
          {"ping_sender_time_ns", m.ping_sender_time_ns},
          {"answer_time_ns", m.answer_time_ns}};
}

Json to_json_of(const wire::Goodbye& m) {
  return {{"type", "Goodbye"}, {"epoch", m.epoch}};
}

Json to_json_of(const wire::Status& m) {
  return {
      {"type", "Status"}, {"epoch", m.epoch}, {"contested_names", m.contested_names}, {"message", m.message}};
}

Json to_json_of(const wire::UnknownMessage& m) {
  return {{"type", "UnknownMessage"}, {"body_type", m.body_type}};
}

Json to_json_of(const wire::SceneEdit& m) {
  return {{"type", "SceneEdit"},
          {"epoch", m.epoch},
          {"version", m.version},
          {"node", m.node},
          {"property", wire::property_name(m.property)},
          {"value", value_to_json(m.value)}};
}

Json to_json_of(const wire::UnknownEdit& m) {
  return {{"type", "UnknownEdit"}, {"epoch", m.epoch}, {"version", m.version}};
}

Json to_json_of(const wire::ImageRequest& m) {
  return image_to_json(m);
}

Json to_json_of(const wire::ImageFrame& m) {
  return image_to_json(m);
}

Json to_json_of(const wire::ImageRefused& m) {
  return image_to_json(m);
}

Json to_json_of(const wire::InputEvent& m) {
  return {{"type", "InputEvent"},
          {"epoch", m.epoch},
          {"source", m.source},
          {"sequence", m.sequence},
          {"viewer", m.viewer},
          {"time_ns", m.time_ns},
          {"sim_time_ns", m.sim_time_ns},
          {"input", m.input},
          {"action", static_cast<uint8_t>(m.action)},
          {"value", m.value},
          {"text", m.text},
          {"node", m.node},
          {"node_point", m.node_point},
          {"target", m.target}};
}

}  // namespace

Json to_json(const wire::Message& message) {
  return std::visit([](const auto& m) { return to_json_of(m); }, message);
}

wire::Bytes encode_json(const Json& json) {
  const std::string type = json.at("type");
  if (type == "StreamDescription") {
    wire::StreamDescription m;
    json.at("protocol_major").get_to(m.protocol_major);
    json.at("protocol_minor").get_to(m.protocol_minor);
    json.at("epoch").get_to(m.epoch);
    json.at("adapter_name").get_to(m.adapter_name);
    json.at("node_names").get_to(m.node_names);
    json.at("world_from_stream").get_to(m.world_from_stream.m);
    m.body_from_node = matrices_from_json(json.at("body_from_node"));
    json.at("nominal_rate_hz").get_to(m.nominal_rate_hz);
    json.at("scene_uri").get_to(m.scene_uri);
    const Json& clock = json.at("clock");
    clock.at("boot_id").get_to(m.clock.boot_id);
    clock.at("monotonic_at_open_ns").get_to(m.clock.monotonic_at_open_ns);
    clock.at("realtime_at_open_ns").get_to(m.clock.realtime_at_open_ns);
    clock.at("sim_seconds_per_second").get_to(m.clock.sim_seconds_per_second);
    return wire::encode(m);
  }
  if (type == "PoseFrame") {
    wire::PoseFrameView m;
    json.at("epoch").get_to(m.header.epoch);
    json.at("sequence").get_to(m.header.sequence);
    json.at("sim_time_ns").get_to(m.header.sim_time_ns);
    json.at("publish_time_ns").get_to(m.header.publish_time_ns);
    json.at("scene_version").get_to(m.header.scene_version);
    json.at("flags").get_to(m.header.flags);
    json.at("node_count").get_to(m.node_count);
    json.at("first_node").get_to(m.first_node);
    const std::vector<wire::Affine3x4> poses = matrices_from_json(json.at("poses"));
    m.poses = poses;
    const auto indices = json.value("node_indices", std::vector<uint32_t>{});
    m.node_indices = indices;
    return wire::encode(m);
  }
  if (type == "Welcome") {
    wire::Welcome m;
    m.status = static_cast<wire::WelcomeStatus>(json.at("status").get<uint8_t>());
    json.at("protocol_major").get_to(m.protocol_major);
    json.at("protocol_minor").get_to(m.protocol_minor);
    json.at("epoch").get_to(m.epoch);
    json.at("renderer_name").get_to(m.renderer_name);
    json.at("message").get_to(m.message);
    json.at("unmatched_names").get_to(m.unmatched_names);
    json.at("conflicting_names").get_to(m.conflicting_names);
    return wire::encode(m);
  }
  if (type == "SceneEdit") {
    wire::SceneEdit m;
    json.at("epoch").get_to(m.epoch);
    json.at("version").get_to(m.version);
    json.at("node").get_to(m.node);
    const std::string property = json.at("property");
    while (property != wire::property_name(m.property))
      m.property = static_cast<wire::Property>(static_cast<uint8_t>(m.property) + 1);
    m.value = value_from_json(json.at("value"));
    return wire::encode(m);
  }
  if (type == "Ack") return wire::encode(wire::Ack{json.at("epoch"), json.at("sequence")});
  if (type == "Ping") return wire::encode(wire::Ping{json.at("id"), json.at("sender_time_ns")});
  if (type == "Pong") {
    return wire::encode(wire::Pong{json.at("id"), json.at("ping_sender_time_ns"), json.at("answer_time_ns")});
  }
  if (type == "Status") {
    wire::Status m;
    json.at("epoch").get_to(m.epoch);
    json.at("contested_names").get_to(m.contested_names);
    json.at("message").get_to(m.message);
    return wire::encode(m);
  }
  if (type == "InputEvent") {
    wire::InputEvent m;
    json.at("epoch").get_to(m.epoch);
    json.at("source").get_to(m.source);
    json.at("sequence").get_to(m.sequence);
    json.at("viewer").get_to(m.viewer);
    json.at("time_ns").get_to(m.time_ns);
    json.at("sim_time_ns").get_to(m.sim_time_ns);
    json.at("input").get_to(m.input);
    m.action = static_cast<wire::InputAction>(json.at("action").get<uint8_t>());
    json.at("value").get_to(m.value);
    json.at("text").get_to(m.text);
    json.at("node").get_to(m.node);
    json.at("node_point").get_to(m.node_point);
    json.at("target").get_to(m.target);
    return wire::encode(m);
  }
  if (wire::Bytes image = encode_image_json(json); !image.empty()) return image;
  FIRE3DV_ASSERT(type == "Goodbye");
  return wire::encode(wire::Goodbye{json.at("epoch")});
}

}  // namespace fire3dv::conformance
