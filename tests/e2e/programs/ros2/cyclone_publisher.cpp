// ROS 2 publishers as rmw_cyclonedds makes them: Cyclone DDS with its default configuration.
#include <dds/dds.h>

#include <cstdlib>
#include <map>

#include "adapters/ros2/idl/ros.h"
#include "tests/e2e/programs/ros2/commands.h"

namespace fire3dv::ros2_test {
namespace {

builtin_interfaces_msg_dds__Time_ time_of(int64_t stamp_ns) {
  const auto [sec, nanosec] = stamp_parts(stamp_ns);
  return {sec, nanosec};
}

class CycloneWriter : public MessageWriter {
 public:
  CycloneWriter() {
    uint32_t domain = 0;
    if (const char* id = std::getenv("ROS_DOMAIN_ID")) domain = static_cast<uint32_t>(std::atoi(id));
    participant_ = dds_create_participant(domain, nullptr, nullptr);
  }
  ~CycloneWriter() override { dds_delete(participant_); }

  bool open(const std::string& kind, const std::string& topic) override {
    const TopicQuality& wanted = quality(kind);
    const dds_topic_descriptor_t* descriptor = &std_msgs_msg_dds__String__desc;
    if (kind.starts_with("tf")) descriptor = &tf2_msgs_msg_dds__TFMessage__desc;
    if (kind == "clock") descriptor = &rosgraph_msgs_msg_dds__Clock__desc;
    if (kind == "markers") descriptor = &visualization_msgs_msg_dds__MarkerArray__desc;
    if (kind == "joint_states") descriptor = &sensor_msgs_msg_dds__JointState__desc;
    const dds_entity_t dds_topic =
        dds_create_topic(participant_, descriptor, ("rt" + topic).c_str(), nullptr, nullptr);
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, wanted.depth);
    if (wanted.transient_local) {
      dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
      dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST, wanted.depth, DDS_LENGTH_UNLIMITED,
                                  DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
    }
    dds_qset_writer_data_lifecycle(qos, false);
    writers_[kind] = dds_create_writer(participant_, dds_topic, qos, nullptr);
    dds_delete_qos(qos);
    return writers_[kind] > 0;
  }

  size_t readers(const std::string& kind) override {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writers_[kind], &status);
    return status.current_count;
  }

  bool send_transforms(const std::string& kind, const std::vector<TestTransform>& transforms) override {
    std::vector<geometry_msgs_msg_dds__TransformStamped_> raw;
    for (const TestTransform& t : transforms) {
      geometry_msgs_msg_dds__TransformStamped_& to = raw.emplace_back();
      to.header = {time_of(t.stamp_ns), const_cast<char*>(t.parent.c_str())};
      to.child_frame_id = const_cast<char*>(t.child.c_str());
      to.transform.translation = {t.translation[0], t.translation[1], t.translation[2]};
      to.transform.rotation = {t.rotation[0], t.rotation[1], t.rotation[2], t.rotation[3]};
    }
    tf2_msgs_msg_dds__TFMessage_ message{};
    message.transforms._buffer = raw.data();
    message.transforms._length = message.transforms._maximum = static_cast<uint32_t>(raw.size());
    return dds_write(writers_[kind], &message) == DDS_RETCODE_OK;
  }

  bool send_marker(const TestTransform& place, int id, int action, int64_t lifetime_ns) override {
    visualization_msgs_msg_dds__Marker_ marker{};
    char none[] = "";
    marker.header.frame_id = const_cast<char*>(place.parent.c_str());
    marker.ns = const_cast<char*>(place.child.c_str());
    marker.texture_resource = marker.texture.format = marker.text = marker.mesh_resource =
        marker.mesh_file.filename = marker.texture.header.frame_id = none;
    marker.id = id;
    marker.type = 1;
    marker.action = action;
    marker.pose.position = {place.translation[0], place.translation[1], place.translation[2]};
    marker.pose.orientation.w = 1;
    marker.scale = {1, 2, 3};
    marker.color = {1, 0, 0, 1};
    const auto [sec, nanosec] = stamp_parts(lifetime_ns);
    marker.lifetime = {sec, nanosec};
    visualization_msgs_msg_dds__MarkerArray_ message{};
    message.markers._buffer = &marker;
    message.markers._length = message.markers._maximum = 1;
    return dds_write(writers_["markers"], &message) == DDS_RETCODE_OK;
  }

  bool send_text(const std::string& text) override {
    const std_msgs_msg_dds__String_ message{const_cast<char*>(text.c_str())};
    return dds_write(writers_["robot_description"], &message) == DDS_RETCODE_OK;
  }

  bool send_clock(int64_t stamp_ns) override {
    const rosgraph_msgs_msg_dds__Clock_ message{time_of(stamp_ns)};
    return dds_write(writers_["clock"], &message) == DDS_RETCODE_OK;
  }

  bool send_joints(int64_t stamp_ns, const std::vector<TestJoint>& joints, bool is_moving) override {
    char frame[] = "";
    sensor_msgs_msg_dds__JointState_ message{};
    message.header = {time_of(stamp_ns), frame};
    std::vector<char*> names;
    std::vector<double> positions, velocities, efforts;
    for (const TestJoint& joint : joints) {
      names.push_back(const_cast<char*>(joint.name.c_str()));
      positions.push_back(joint.position);
      if (is_moving) velocities.push_back(joint.velocity);
      if (is_moving) efforts.push_back(joint.effort);
    }
    const auto set = [](auto& sequence, std::vector<double>& numbers) {
      sequence._buffer = numbers.data();
      sequence._length = sequence._maximum = static_cast<uint32_t>(numbers.size());
    };
    message.name._buffer = names.data();
    message.name._length = message.name._maximum = static_cast<uint32_t>(names.size());
    set(message.position, positions);
    set(message.velocity, velocities);
    set(message.effort, efforts);
    return dds_write(writers_["joint_states"], &message) == DDS_RETCODE_OK;
  }

 private:
  dds_entity_t participant_ = 0;
  std::map<std::string, dds_entity_t> writers_;
};

}  // namespace
}  // namespace fire3dv::ros2_test

int main() {
  fire3dv::ros2_test::CycloneWriter writer;
  return fire3dv::ros2_test::run_commands(writer);
}
