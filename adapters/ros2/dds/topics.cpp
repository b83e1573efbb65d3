#include "adapters/ros2/dds/topics.h"

namespace fire3dv::ros2 {
namespace {

constexpr int32_t kStaticReaderDepth = 1000;  // samples without key: one for each broadcaster that is alive

struct Quality {
  bool reliable;
  bool transient_local;
  int32_t depth;
};

Quality reader_quality(Profile profile) {
  switch (profile) {
    case Profile::tf:
      return {true, false, 100};
    case Profile::tf_static:
      return {true, true, kStaticReaderDepth};
    case Profile::clock:
      return {false, false, 1};
    case Profile::joint_states:
      return {false, false, 5};
    case Profile::robot_description:
      return {true, true, 1};
    case Profile::image:
      return {true, false, 1};
    case Profile::markers:
      return {true, false, 10};
    case Profile::points:
      return {false, false, 1};
    case Profile::path:
      return {true, false, 1};
    case Profile::map:
      return {true, true, 1};
    case Profile::camera_info:
      break;
  }
  return {false, false, 5};
}

Quality writer_quality(Profile profile) {
  switch (profile) {
    case Profile::tf:
      return {true, false, 100};
    case Profile::tf_static:
      return {true, true, 1};
    case Profile::clock:
      return {true, false, 1};
    case Profile::joint_states:
      return {true, false, 10};
    case Profile::robot_description:
      return {true, true, 1};
    case Profile::image:
      return {true, false, 1};
    case Profile::markers:
      return {true, false, 10};
    case Profile::points:
      return {true, false, 1};
    case Profile::path:
      return {true, false, 1};
    case Profile::map:
      return {true, true, 1};
    case Profile::camera_info:
      break;
  }
  return {true, false, 5};
}

UniqueQos create_qos(const Quality& quality, const MessageType& type) {
  UniqueQos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), quality.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(100));
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, quality.depth);
  if (quality.transient_local) dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  if (!type.hash.empty()) {
    const std::string hash = "typehash=RIHS01_" + std::string(type.hash) + ";";
    dds_qset_userdata(qos.get(), hash.data(), hash.size());
  }
  return qos;
}

template <typename Create>
Result<Entity> create_endpoint(const Participant& participant, const std::string& name,
                               const MessageType& type, const char* kind, Create&& create) {
  const std::string topic_name = dds_topic_name(name);
  const Entity topic(
      dds_create_topic(participant.get(), type.descriptor, topic_name.c_str(), nullptr, nullptr));
  if (!topic) return Error{"topic " + name + " cannot be created (" + dds_text(topic.get()) + ")"};
  Entity endpoint(create(topic.get()));
  if (!endpoint) return Error{"topic " + name + " has no " + kind + " (" + dds_text(endpoint.get()) + ")"};
  return endpoint;
}

}  // namespace

UniqueQos reader_qos(Profile profile, const MessageType& type) {
  return create_qos(reader_quality(profile), type);
}

UniqueQos writer_qos(Profile profile, const MessageType& type) {
  const Quality quality = writer_quality(profile);
  UniqueQos qos = create_qos(quality, type);
  // Late joiners get what the durability service stores; its depth is not that of the history.
  if (quality.transient_local)
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, quality.depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  dds_qset_writer_data_lifecycle(qos.get(), false);
  return qos;
}

Result<Entity> create_reader(const Participant& participant, const std::string& name, const MessageType& type,
                             const dds_qos_t* qos) {
  return create_endpoint(participant, name, type, "reader", [&](dds_entity_t topic) {
    return dds_create_reader(participant.get(), topic, qos, nullptr);
  });
}

Result<Entity> create_writer(const Participant& participant, const std::string& name, const MessageType& type,
                             const dds_qos_t* qos) {
  return create_endpoint(participant, name, type, "writer", [&](dds_entity_t topic) {
    return dds_create_writer(participant.get(), topic, qos, nullptr);
  });
}

}  // namespace fire3dv::ros2
