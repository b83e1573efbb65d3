// Typed readers and writers of ROS 2 topics: DDS names, quality of service and type hashes as ROS 2's own
// nodes use them.
#pragma once

#include <dds/dds.h>

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "adapters/ros2/dds/names.h"
#include "adapters/ros2/dds/participant.h"
#include "adapters/ros2/idl/ros.h"
#include "base/error.h"

namespace fire3dv::ros2 {

struct DeleteQos {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using UniqueQos = std::unique_ptr<dds_qos_t, DeleteQos>;

using TfMessage = tf2_msgs_msg_dds__TFMessage_;
using StringMessage = std_msgs_msg_dds__String_;
using ClockMessage = rosgraph_msgs_msg_dds__Clock_;
using JointStateMessage = sensor_msgs_msg_dds__JointState_;
using ImageMessage = sensor_msgs_msg_dds__Image_;
using CompressedImageMessage = sensor_msgs_msg_dds__CompressedImage_;
using CameraInfoMessage = sensor_msgs_msg_dds__CameraInfo_;
using MarkerMessage = visualization_msgs_msg_dds__Marker_;
using MarkerArrayMessage = visualization_msgs_msg_dds__MarkerArray_;
using PointCloudMessage = sensor_msgs_msg_dds__PointCloud2_;
using PathMessage = nav_msgs_msg_dds__Path_;
using MapMessage = nav_msgs_msg_dds__OccupancyGrid_;

// Type of a message: DDS descriptor and ROS 2's type hash (REP 2011).
struct MessageType {
  const dds_topic_descriptor_t* descriptor;
  std::string_view hash;  // 64 hexadecimal digits of RIHS01; empty: not announced
};
template <typename Message>
inline constexpr MessageType kMessageType{};
template <>
inline constexpr MessageType kMessageType<TfMessage>{
    &tf2_msgs_msg_dds__TFMessage__desc, "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"};
template <>
inline constexpr MessageType kMessageType<StringMessage>{
    &std_msgs_msg_dds__String__desc, "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"};
template <>
inline constexpr MessageType kMessageType<ClockMessage>{
    &rosgraph_msgs_msg_dds__Clock__desc, "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564"};
template <>
inline constexpr MessageType kMessageType<JointStateMessage>{
    &sensor_msgs_msg_dds__JointState__desc,
    "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"};
template <>
inline constexpr MessageType kMessageType<ImageMessage>{
    &sensor_msgs_msg_dds__Image__desc, "d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47"};
template <>
inline constexpr MessageType kMessageType<CompressedImageMessage>{
    &sensor_msgs_msg_dds__CompressedImage__desc,
    "15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a"};
template <>
inline constexpr MessageType kMessageType<CameraInfoMessage>{
    &sensor_msgs_msg_dds__CameraInfo__desc,
    "b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275"};
template <>
inline constexpr MessageType kMessageType<MarkerArrayMessage>{
    &visualization_msgs_msg_dds__MarkerArray__desc,
    "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf"};
template <>
inline constexpr MessageType kMessageType<PointCloudMessage>{&sensor_msgs_msg_dds__PointCloud2__desc, ""};
template <>
inline constexpr MessageType kMessageType<PathMessage>{&nav_msgs_msg_dds__Path__desc, ""};
template <>
inline constexpr MessageType kMessageType<MapMessage>{&nav_msgs_msg_dds__OccupancyGrid__desc, ""};

// Quality of service of a topic's ends. Readers are no more demanding than the usual writers, writers meet
// reliable and best-effort readers.
enum class Profile {
  tf,                 // reliable, volatile, 100
  tf_static,          // reliable, transient local; reader 1000, writer 1: always write the whole set
  clock,              // reader best effort, 1; writer reliable, 1
  joint_states,       // reader best effort, 5; writer reliable, 10
  robot_description,  // reliable, transient local, 1
  image,              // reliable, volatile, 1
  camera_info,        // reader best effort, 5; writer reliable, 5
  markers,            // reliable, volatile, 10
  points,             // reader best effort, 1
  path,               // reliable, volatile, 1
  map                 // reliable, transient local, 1
};

UniqueQos reader_qos(Profile profile, const MessageType& type);
UniqueQos writer_qos(Profile profile, const MessageType& type);

// Topic, and reader or writer, of an absolute ROS name ("/tf"). Errors name the topic. The reader or writer
// holds its topic.
Result<Entity> create_reader(const Participant& participant, const std::string& name, const MessageType& type,
                             const dds_qos_t* qos);
Result<Entity> create_writer(const Participant& participant, const std::string& name, const MessageType& type,
                             const dds_qos_t* qos);

template <typename Message>
class Reader {
 public:
  static Result<Reader> open(const Participant& participant, const std::string& name, Profile profile) {
    const UniqueQos qos = reader_qos(profile, kMessageType<Message>);
    Result<Entity> entity = create_reader(participant, name, kMessageType<Message>, qos.get());
    if (!entity) return entity.error();
    return Reader(std::move(*entity));
  }

  dds_entity_t get() const { return entity_.get(); }

  // Calls take(message, info) for each sample that has arrived, in order, at most kBatch times. Returns the
  // number of samples, also of those without data. The message is borrowed for the call.
  template <typename Take>
  size_t take(Take&& take) {
    std::array<void*, kBatch> samples{};
    std::array<dds_sample_info_t, kBatch> infos;
    const dds_return_t count = dds_take(entity_.get(), samples.data(), infos.data(), kBatch, kBatch);
    if (count <= 0) return 0;
    for (size_t i = 0; i < static_cast<size_t>(count); ++i)
      if (infos[i].valid_data) take(*static_cast<const Message*>(samples[i]), infos[i]);
    dds_return_loan(entity_.get(), samples.data(), count);
    return static_cast<size_t>(count);
  }

 private:
  static constexpr size_t kBatch = 64;

  explicit Reader(Entity entity) : entity_(std::move(entity)) {}

  Entity entity_;
};

template <typename Message>
class Writer {
 public:
  static Result<Writer> open(const Participant& participant, const std::string& name, Profile profile) {
    const UniqueQos qos = writer_qos(profile, kMessageType<Message>);
    Result<Entity> entity = create_writer(participant, name, kMessageType<Message>, qos.get());
    if (!entity) return entity.error();
    return Writer(std::move(*entity));
  }

  dds_entity_t get() const { return entity_.get(); }

  // Copies the message. May wait up to 100 ms (DDS's max_blocking_time) for a reliable reader that falls
  // behind.
  Result<void> write(const Message& message) {
    const dds_return_t code = dds_write(entity_.get(), &message);
    if (code < 0) return Error{dds_text(code)};
    return {};
  }

  // Number of matched readers.
  size_t reader_count() const {
    dds_publication_matched_status_t status{};
    return dds_get_publication_matched_status(entity_.get(), &status) < 0 ? 0 : status.current_count;
  }

 private:
  explicit Writer(Entity entity) : entity_(std::move(entity)) {}

  Entity entity_;
};

}  // namespace fire3dv::ros2
