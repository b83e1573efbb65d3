// Reader of one topic by Fast DDS, the other DDS library of ROS 2: writes each message's bytes to a file.
//
//   ros2_fastdds_reader DOMAIN TOPIC TYPE reliable|best_effort volatile|transient_local FOLDER
//   ros2_fastdds_reader 7 rt/cam/image_raw sensor_msgs::msg::dds_::Image_ reliable volatile /tmp/images
//
// Prints "matched" when a writer is found, then "N BYTES" for each message, whose CDR is FOLDER/N.cdr. Ends
// with its standard input.
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

using Bytes = std::vector<uint8_t>;

// Messages as they are on the wire.
class RawType : public fast::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 1024;  // payloads grow
    m_isGetKeyDefined = false;
  }
  bool serialize(void*, rtps::SerializedPayload_t*) override { return false; }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void*) override {
    return [] { return uint32_t{1024}; };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

class FileWriter : public fast::DataReaderListener {
 public:
  explicit FileWriter(std::string folder) : folder_(std::move(folder)) {}

  void on_subscription_matched(fast::DataReader*, const fast::SubscriptionMatchedStatus& status) override {
    if (status.current_count_change > 0) say("matched");
  }
  void on_data_available(fast::DataReader* reader) override {
    fast::SampleInfo info;
    while (reader->take_next_sample(&bytes_, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      const std::string number = std::to_string(++count_);
      const std::string path = folder_ + "/" + number + ".cdr";
      std::ofstream file(path + ".part", std::ios::binary);
      file.write(reinterpret_cast<const char*>(bytes_.data()), static_cast<std::streamsize>(bytes_.size()));
      file.close();
      if (std::rename((path + ".part").c_str(), path.c_str()) != 0) std::abort();
      say(number + " " + std::to_string(bytes_.size()));
    }
  }

 private:
  static void say(const std::string& line) {
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
  }

  std::string folder_;
  Bytes bytes_;
  uint64_t count_ = 0;
};

int fail(const char* what) {
  std::fprintf(stderr, "ros2_fastdds_reader: error: %s\n", what);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) return fail("usage: DOMAIN TOPIC TYPE reliable|best_effort volatile|transient_local FOLDER");
  auto* const factory = fast::DomainParticipantFactory::get_instance();
  auto* const participant =
      factory->create_participant(static_cast<uint32_t>(std::atoi(argv[1])), fast::PARTICIPANT_QOS_DEFAULT);
  if (!participant) return fail("no participant");
  fast::TypeSupport type(new RawType(argv[3]));
  type.register_type(participant);
  fast::Topic* const topic = participant->create_topic(argv[2], argv[3], fast::TOPIC_QOS_DEFAULT);
  fast::Subscriber* const subscriber = participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  if (!topic || !subscriber) return fail("no topic");
  fast::DataReaderQos qos;
  qos.reliability().kind = std::strcmp(argv[4], "reliable") == 0 ? fast::RELIABLE_RELIABILITY_QOS
                                                                 : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = std::strcmp(argv[5], "volatile") == 0 ? fast::VOLATILE_DURABILITY_QOS
                                                                : fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 5;  // as rviz
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  FileWriter listener(argv[6]);
  fast::DataReader* const reader = subscriber->create_datareader(topic, qos, &listener);
  if (!reader) return fail("no reader");
  char rest[64];
  while (read(STDIN_FILENO, rest, sizeof rest) > 0) {
  }
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return 0;
}
