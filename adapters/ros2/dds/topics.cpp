#include "adapters/ros2/dds/topics.h"

#include <iterator>

namespace fire3dv::ros2 {
namespace {

constexpr int32_t kStaticReaderDepth = 1000;  // samples without key: one for each broadcaster that is alive

// Writers are reliable.
struct ProfileQuality {
  bool reads_reliably;
  bool transient_local;
  int32_t reader_depth, writer_depth;
};

// In the order of Profile.
constexpr ProfileQuality kProfiles[] = {
    {true, false, 100, 100},              // tf
    {true, true, kStaticReaderDepth, 1},  // tf_static
    {false, false, 1, 1},                 // clock
    {false, false, 5, 10},                // joint_states
    {true, true, 1, 1},                   // robot_description
    {true, false, 1, 1},                  // image
    {false, false, 5, 5},                 // camera_info
    {true, false, 10, 10},                // markers
    {false, false, 1, 1},                 // points
    {true, false, 1, 1},                  // path
    {true, true, 1, 1},                   // map
};
static_assert(std::size(kProfiles) == static_cast<size_t>(Profile::map) + 1);

struct Quality {
  bool reliable;
  bool transient_local;
  int32_t depth;
};

Quality reader_quality(Profile profile) {
  const ProfileQuality& quality = kProfiles[static_cast<size_t>(profile)];
  return {quality.reads_reliably, quality.transient_local, quality.reader_depth};
}

Quality writer_quality(Profile profile) {
  const ProfileQuality& quality = kProfiles[static_cast<size_t>(profile)];
  return {true, quality.transient_local, quality.writer_depth};
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
