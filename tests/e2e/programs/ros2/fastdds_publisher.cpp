// ROS 2 publishers as rmw_fastrtps makes them: Fast DDS, whose types copy bytes that Fast CDR has written.
// Nothing is shared with the adapter.
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/core/status/PublicationMatchedStatus.hpp>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <random>

#include "tests/e2e/programs/ros2/commands.h"

namespace fire3dv::ros2_test {
namespace {

namespace dds = eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;
using Bytes = std::vector<char>;

class RawType : public dds::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 64 * 1024;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<Bytes*>(data);
    payload->length = static_cast<uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    return true;
  }
  bool deserialize(SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, InstanceHandle_t*, bool) override { return false; }
};

template <typename Write>
Bytes encode(size_t most, Write&& write) {
  Bytes bytes(most);
  FastBuffer buffer(bytes.data(), bytes.size());
  Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  write(cdr);
  bytes.resize(cdr.getSerializedDataLength());
  return bytes;
}

void write_stamp(Cdr& cdr, int64_t stamp_ns) {
  const auto [sec, nanosec] = stamp_parts(stamp_ns);
  cdr << sec << nanosec;
}

class FastDdsWriter : public MessageWriter {
 public:
  FastDdsWriter() {
    uint32_t domain = 0;
    if (const char* id = std::getenv("ROS_DOMAIN_ID")) domain = static_cast<uint32_t>(std::atoi(id));
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(
        domain, dds::PARTICIPANT_QOS_DEFAULT);
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  }
  ~FastDdsWriter() override {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  bool open(const std::string& kind, const std::string& topic) override {
    const TopicQuality& wanted = quality(kind);
    dds::TypeSupport type(new RawType(wanted.type));
    type.register_type(participant_);
    dds::Topic* dds_topic = participant_->create_topic("rt" + topic, wanted.type, dds::TOPIC_QOS_DEFAULT);
    dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = wanted.depth;
    qos.durability().kind =
        wanted.transient_local ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
    writers_[kind] = publisher_->create_datawriter(dds_topic, qos);
    return writers_[kind] != nullptr;
  }

  size_t readers(const std::string& kind) override {
    dds::PublicationMatchedStatus status;
    writers_[kind]->get_publication_matched_status(status);
    return static_cast<size_t>(status.current_count);
  }

  bool send_transforms(const std::string& kind, const std::vector<TestTransform>& transforms) override {
    size_t most = 64;
    for (const TestTransform& t : transforms) most += 128 + t.parent.size() + t.child.size();
    return send(kind, encode(most, [&](Cdr& cdr) {
                  cdr << static_cast<uint32_t>(transforms.size());
                  for (const TestTransform& t : transforms) {
                    write_stamp(cdr, t.stamp_ns);
                    cdr << t.parent << t.child;
                    for (const double number : t.translation) cdr << number;
                    for (const double number : t.rotation) cdr << number;
                  }
                }));
  }

  bool send_text(const std::string& text) override {
    return send("robot_description", encode(text.size() + 64, [&](Cdr& cdr) { cdr << text; }));
  }

  bool send_clock(int64_t stamp_ns) override {
    return send("clock", encode(64, [&](Cdr& cdr) { write_stamp(cdr, stamp_ns); }));
  }

  bool send_joints(int64_t stamp_ns, const std::vector<TestJoint>& joints, bool is_moving) override {
    size_t most = 128;
    for (const TestJoint& joint : joints) most += 80 + joint.name.size();
    return send(
        "joint_states", encode(most, [&](Cdr& cdr) {
          write_stamp(cdr, stamp_ns);
          cdr << std::string();
          const auto count = static_cast<uint32_t>(joints.size());
          cdr << count;
          for (const TestJoint& joint : joints) cdr << joint.name;
          for (double TestJoint::*number : {&TestJoint::position, &TestJoint::velocity, &TestJoint::effort}) {
            const bool is_sent = is_moving || number == &TestJoint::position;
            cdr << (is_sent ? count : uint32_t{0});
            if (!is_sent) continue;
            for (const TestJoint& joint : joints) cdr << joint.*number;
          }
        }));
  }

  // Starts from the last whole message of this kind.
  bool send_damaged(const std::string& kind, size_t count, unsigned seed) override {
    const Bytes whole = last_[kind];
    std::mt19937 random(seed);
    const auto below = [&](size_t limit) {
      return std::uniform_int_distribution<size_t>(0, limit - 1)(random);
    };
    for (size_t i = 0; i < count; ++i) {
      Bytes bytes = whole;
      for (size_t changes = below(4); changes > 0; --changes) {
        const size_t at = 4 + below(bytes.size() - 4);
        bytes[at] = static_cast<char>(below(2) == 0 ? below(256) : 0xff);
      }
      if (below(3) == 0) bytes.resize(4 + below(bytes.size() - 3));
      if (below(8) == 0) bytes.resize(bytes.size() + below(1000));
      if (!writers_[kind]->write(&bytes)) return false;
    }
    return true;
  }

 private:
  bool send(const std::string& kind, Bytes bytes) {
    last_[kind] = bytes;
    return writers_[kind]->write(&bytes);
  }

  dds::DomainParticipant* participant_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  std::map<std::string, dds::DataWriter*> writers_;
  std::map<std::string, Bytes> last_;
};

}  // namespace
}  // namespace fire3dv::ros2_test

int main() {
  fire3dv::ros2_test::FastDdsWriter writer;
  return fire3dv::ros2_test::run_commands(writer);
}
