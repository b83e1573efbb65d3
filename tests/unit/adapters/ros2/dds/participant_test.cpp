// Domain settings from ROS 2's environment variables, and the configuration that follows from them.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "adapters/ros2/dds/participant.h"
#include "adapters/ros2/dds/topics.h"

namespace fire3dv::ros2 {
namespace {

Result<DomainSettings> read(const std::map<std::string, std::string>& environment,
                            std::optional<uint32_t> domain = {}) {
  return domain_settings(
      [&](const char* name) -> const char* {
        const auto found = environment.find(name);
        return found == environment.end() ? nullptr : found->second.c_str();
      },
      domain);
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Ros2Domain, DefaultsAreRos2s) {
  const Result<DomainSettings> settings = read({});
  ASSERT_TRUE(settings.ok());
  EXPECT_EQ(settings->domain_id, 0u);
  EXPECT_EQ(settings->range, DiscoveryRange::subnet);
  const std::string xml = cyclonedds_configuration(*settings);
  EXPECT_TRUE(has(xml, "<ParticipantIndex>auto</ParticipantIndex>"));
  EXPECT_TRUE(has(xml, "<Peer Address=\"localhost\"/>"));
  EXPECT_FALSE(has(xml, "AllowMulticast"));
  EXPECT_FALSE(has(xml, "NetworkInterface"));
}

TEST(Ros2Domain, TheOptionReplacesTheVariable) {
  EXPECT_EQ(read({{"ROS_DOMAIN_ID", "42"}})->domain_id, 42u);
  EXPECT_EQ(read({{"ROS_DOMAIN_ID", "x"}}, 7)->domain_id, 7u);
  for (const char* wrong : {"x", "-1", "233", "1 ", "0x1", "99999999999"}) {
    const Result<DomainSettings> settings = read({{"ROS_DOMAIN_ID", wrong}});
    ASSERT_FALSE(settings.ok()) << wrong;
    EXPECT_TRUE(has(settings.error().message, "ROS_DOMAIN_ID"));
  }
  EXPECT_FALSE(read({}, 233).ok());
}

TEST(Ros2Domain, RangesChangeDiscovery) {
  const auto xml = [](std::map<std::string, std::string> environment) {
    const Result<DomainSettings> settings = read(environment);
    return settings ? cyclonedds_configuration(*settings) : settings.error().message;
  };
  const std::string local = xml({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"}});
  EXPECT_TRUE(has(local, "<AllowMulticast>false</AllowMulticast>") && has(local, "localhost"));
  const std::string loopback = xml({{"ROS_LOCALHOST_ONLY", "1"}});
  EXPECT_TRUE(has(loopback, "<NetworkInterface name=\"lo\"/>") && !has(loopback, "AllowMulticast"));
  // Interfaces of the user's configuration are neither named again nor listed wrongly.
  const std::map<std::string, std::string> own = {
      {"ROS_LOCALHOST_ONLY", "1"},
      {"CYCLONEDDS_URI", "<General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces></General>"}};
  EXPECT_FALSE(has(xml(own), "NetworkInterface"));
  EXPECT_TRUE(domain_text(*read(own)).ends_with("interfaces of CYCLONEDDS_URI"));
  EXPECT_TRUE(domain_text(*read({{"ROS_LOCALHOST_ONLY", "1"}})).ends_with("interfaces lo"));
  const std::string off = xml({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"}, {"ROS_STATIC_PEERS", "a"}});
  EXPECT_TRUE(has(off, "<Tag>ros_discovery_off_") && !has(off, "Peer "));
  const std::string peers = xml({{"ROS_STATIC_PEERS", ";10.0.0.1;a\"<&>;"}});
  EXPECT_TRUE(has(peers, "\"10.0.0.1\"") && has(peers, "\"a&quot;&lt;&amp;&gt;\""));
  EXPECT_TRUE(has(xml({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "NEAR"}}), "SUBNET, LOCALHOST, OFF"));
  EXPECT_TRUE(has(xml({{"ROS_LOCALHOST_ONLY", "yes"}}), "ROS_LOCALHOST_ONLY"));
}

// Two ends in one process, by loopback alone: a late reader receives the whole static set.
TEST(Ros2Domain, LateReaderGetsStatic) {
  DomainSettings settings;
  settings.domain_id = 97;
  settings.range = DiscoveryRange::off;
  Result<std::unique_ptr<Participant>> participant = Participant::open(settings);
  ASSERT_TRUE(participant.ok()) << participant.error().message;
  Result<Writer<TfMessage>> writer = Writer<TfMessage>::open(**participant, "/tf_static", Profile::tf_static);
  ASSERT_TRUE(writer.ok()) << writer.error().message;
  char parent[] = "map", child[] = "odom";
  geometry_msgs_msg_dds__TransformStamped_ transform{};
  transform.header.frame_id = parent;
  transform.child_frame_id = child;
  TfMessage message{};
  message.transforms._length = message.transforms._maximum = 1;
  message.transforms._buffer = &transform;
  for (int i = 1; i <= 3; ++i) {
    transform.transform.translation.x = i;
    ASSERT_TRUE(writer->write(message).ok());
  }
  Result<Reader<TfMessage>> reader = Reader<TfMessage>::open(**participant, "/tf_static", Profile::tf_static);
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  int received = 0;
  reader->take([&](const TfMessage& taken, const dds_sample_info_t&) {
    ++received;
    ASSERT_EQ(taken.transforms._length, 1u);
    EXPECT_STREQ(taken.transforms._buffer[0].child_frame_id, "odom");
    EXPECT_EQ(taken.transforms._buffer[0].transform.translation.x, 3);
  });
  EXPECT_EQ(received, 1);
}

TEST(Ros2Domain, WrongConfigurationIsError) {
  DomainSettings settings;
  settings.domain_id = 98;
  settings.cyclonedds_uri = "<CycloneDDS><Domain><Nonsense/></Domain></CycloneDDS>";
  const Result<std::unique_ptr<Participant>> participant = Participant::open(settings);
  ASSERT_FALSE(participant.ok());
  EXPECT_TRUE(has(participant.error().message, "CYCLONEDDS_URI"));
}

}  // namespace
}  // namespace fire3dv::ros2
