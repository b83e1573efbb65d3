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

template <>
const MessageType& message_type<TfMessage>() {
  static constexpr MessageType type{&tf2_msgs_msg_dds__TFMessage__desc,
                                    "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"};
  return type;
}
template <>
const MessageType& message_type<StringMessage>() {
  static constexpr MessageType type{&std_msgs_msg_dds__String__desc,
                                    "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"};
  return type;
}
template <>
const MessageType& message_type<ClockMessage>() {
  static constexpr MessageType type{&rosgraph_msgs_msg_dds__Clock__desc,
                                    "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564"};
  return type;
}
template <>
const MessageType& message_type<JointStateMessage>() {
  static constexpr MessageType type{&sensor_msgs_msg_dds__JointState__desc,
                                    "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"};
  return type;
}
template <>
const MessageType& message_type<ImageMessage>() {
  static constexpr MessageType type{&sensor_msgs_msg_dds__Image__desc,
                                    "d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47"};
  return type;
}
template <>
const MessageType& message_type<CompressedImageMessage>() {
  static constexpr MessageType type{&sensor_msgs_msg_dds__CompressedImage__desc,
                                    "15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a"};
  return type;
}
template <>
const MessageType& message_type<CameraInfoMessage>() {
  static constexpr MessageType type{&sensor_msgs_msg_dds__CameraInfo__desc,
                                    "b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275"};
  return type;
}

template <>
const MessageType& message_type<MarkerArrayMessage>() {
  static constexpr MessageType type{&visualization_msgs_msg_dds__MarkerArray__desc,
                                    "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf"};
  return type;
}
template <>
const MessageType& message_type<PointCloudMessage>() {
  static constexpr MessageType type{&sensor_msgs_msg_dds__PointCloud2__desc, ""};
  return type;
}
template <>
const MessageType& message_type<PathMessage>() {
  static constexpr MessageType type{&nav_msgs_msg_dds__Path__desc, ""};
  return type;
}
template <>
const MessageType& message_type<MapMessage>() {
  static constexpr MessageType type{&nav_msgs_msg_dds__OccupancyGrid__desc, ""};
  return type;
}

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
