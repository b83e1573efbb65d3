// Discovery datagrams of Gazebo Transport: golden bytes that Debian 12's ignition-transport 11.0.0 sent, and
// hostile ones.
#include "adapters/gazebo/wire/discovery.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "adapters/gazebo/wire/directory.h"

namespace fire3dv::gazebo {
namespace {

// A publisher of gz.msgs.Pose_V.
constexpr std::string_view kAdvertiseTopic =
    "d600100a1a2462306436663365352d623139362d343161652d613238642d6538326539363562353362342001"
    "3aa9010a1d402f74657374402f776f726c642f6f746865722f706f73652f696e666f12157463703a2f2f3132"
    "372e302e302e313a34343030371a2462306436663365352d623139362d343161652d613238642d6538326539"
    "36356235336234222431323437313730632d386263632d343630612d626261362d3437313539623066373234"
    "33280232230a06756e75736564120e677a2e6d7367732e506f73655f5620ffffffffffffffffff01";
// The scene/info service of ignition.msgs.
constexpr std::string_view kAdvertiseService =
    "0301100a1a2438623862653933342d653532392d343964392d386430642d3238313335343739306666332001"
    "3ad6010a1d402f74657374402f776f726c642f64656d6f2f7363656e652f696e666f12157463703a2f2f3132"
    "372e302e302e313a34333231391a2438623862653933342d653532392d343964392d386430642d3238313335"
    "34373930666633222463656266306434392d656330342d346136302d613434392d3437356430663034383962"
    "3428023a500a2463333634343164352d353465652d343735632d623666362d33333332363036346338346312"
    "1369676e6974696f6e2e6d7367732e456d7074791a1369676e6974696f6e2e6d7367732e5363656e65";
// A subscriber of /nothing.
constexpr std::string_view kSubscribe =
    "3d00100a1a2438623862653933342d653532392d343964392d386430642d3238313335343739306666332002"
    "32110a0f402f74657374402f6e6f7468696e67";
constexpr std::string_view kHeartbeat =
    "2a00100a1a2462306436663365352d623139362d343161652d613238642d6538326539363562353362342004";
// A subscriber of /world/demo/pose/info, to its publisher.
constexpr std::string_view kNewConnection =
    "f900100a1a2435303430356131622d306131622d343335382d623730312d3062393033653739646235372006"
    "3acc010a1c402f74657374402f776f726c642f64656d6f2f706f73652f696e666f12157463703a2f2f313237"
    "2e302e302e313a34353632371a2435303430356131622d306131622d343335382d623730312d306239303365"
    "373964623537222436346166623965622d643930342d343862632d613437642d646164376436613561363434"
    "280232470a2462633235393334312d303035642d343963322d393032642d3232633164643832636664391214"
    "69676e6974696f6e2e6d7367732e506f73655f5620ffffffffffffffffff01";

std::vector<std::byte> bytes_of_hex(std::string_view hex) {
  std::vector<std::byte> bytes;
  for (size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  return bytes;
}

DiscoveryMessage decoded(std::string_view hex) {
  const std::optional<DiscoveryMessage> message = decode_discovery(bytes_of_hex(hex));
  EXPECT_TRUE(message);
  return message.value_or(DiscoveryMessage());
}

TEST(GazeboDiscovery, ReadsTopics) {
  const DiscoveryMessage message = decoded(kAdvertiseTopic);
  EXPECT_EQ(message.version, kWireVersion);
  EXPECT_EQ(message.type, DiscoveryType::advertise);
  EXPECT_EQ(message.process_uuid, "b0d6f3e5-b196-41ae-a28d-e82e965b53b4");
  ASSERT_TRUE(message.advertisement);
  EXPECT_EQ(message.advertisement->topic, "@/test@/world/other/pose/info");
  EXPECT_EQ(message.advertisement->address, "tcp://127.0.0.1:44007");
  EXPECT_EQ(message.advertisement->process_uuid, message.process_uuid);
  EXPECT_EQ(message.advertisement->message_type, "gz.msgs.Pose_V");
  EXPECT_EQ(message.advertisement->scope, 2);
  EXPECT_FALSE(message.advertisement->is_service);
}

TEST(GazeboDiscovery, ReadsServices) {
  const DiscoveryMessage message = decoded(kAdvertiseService);
  ASSERT_TRUE(message.advertisement);
  EXPECT_TRUE(message.advertisement->is_service);
  EXPECT_EQ(message.advertisement->topic, "@/test@/world/demo/scene/info");
  EXPECT_EQ(message.advertisement->request_type, "ignition.msgs.Empty");
  EXPECT_EQ(message.advertisement->response_type, "ignition.msgs.Scene");
  EXPECT_EQ(message.advertisement->socket_id.size(), 36u);
}

TEST(GazeboDiscovery, ReadsSubscribersAndHeartbeats) {
  EXPECT_EQ(decoded(kSubscribe).type, DiscoveryType::subscribe);
  EXPECT_EQ(decoded(kSubscribe).topic, "@/test@/nothing");
  EXPECT_EQ(decoded(kHeartbeat).type, DiscoveryType::heartbeat);
  const DiscoveryMessage connection = decoded(kNewConnection);
  EXPECT_EQ(connection.type, DiscoveryType::new_connection);
  ASSERT_TRUE(connection.advertisement);
  EXPECT_EQ(connection.advertisement->process_uuid, connection.process_uuid);
  EXPECT_EQ(connection.advertisement->ctrl.size(), 36u);
  EXPECT_NE(connection.advertisement->ctrl, connection.process_uuid);
}

TEST(GazeboDiscovery, WritesTheSameBytes) {
  for (const std::string_view hex :
       {kAdvertiseTopic, kAdvertiseService, kSubscribe, kHeartbeat, kNewConnection})
    EXPECT_EQ(encode_discovery(decoded(hex)), bytes_of_hex(hex));
}

TEST(GazeboDiscovery, MarksRelays) {
  DiscoveryMessage message = decoded(kHeartbeat);
  message.is_relay = true;
  const std::vector<std::byte> datagram = encode_discovery(message);
  EXPECT_EQ(datagram.size(), bytes_of_hex(kHeartbeat).size() + 4);  // flags {relay}
  const std::optional<DiscoveryMessage> read = decode_discovery(datagram);
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->is_relay);
  EXPECT_FALSE(read->is_no_relay);
}

TEST(GazeboDiscovery, TruncationsAreRefused) {
  const std::vector<std::byte> whole = bytes_of_hex(kAdvertiseService);
  for (size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(decode_discovery(std::span(whole).first(size))) << size;
  std::vector<std::byte> longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(decode_discovery(longer));
}

TEST(GazeboDiscovery, LongTextsAreRefused) {
  DiscoveryMessage message = decoded(kAdvertiseTopic);
  message.advertisement->address = std::string(5000, 'x');
  EXPECT_FALSE(decode_discovery(encode_discovery(message)));
  message = decoded(kAdvertiseTopic);
  message.advertisement->topic = "no partition";
  EXPECT_FALSE(decode_discovery(encode_discovery(message)));
  message = decoded(kHeartbeat);
  message.type = static_cast<DiscoveryType>(9);
  EXPECT_FALSE(decode_discovery(encode_discovery(message)));
  message.advertisement = decoded(kAdvertiseTopic).advertisement;
  message.advertisement->message_type = std::string(70'000, 'x');
  EXPECT_TRUE(encode_discovery(message).empty());
}

TEST(GazeboDiscovery, SplitsNames) {
  const std::optional<QualifiedName> name = split_qualified_name("@/host:me@/world/a/stats");
  ASSERT_TRUE(name);
  EXPECT_EQ(name->partition, "host:me");
  EXPECT_EQ(name->name, "/world/a/stats");
  EXPECT_EQ(qualified_name(name->partition, name->name), "@/host:me@/world/a/stats");
  ASSERT_TRUE(split_qualified_name("@@/a"));
  EXPECT_EQ(qualified_name("", "a"), "@@/a");
  for (const char* wrong : {"", "@", "@/p", "/p@/a", "@/p@a"})
    EXPECT_FALSE(split_qualified_name(wrong)) << wrong;
}

TEST(GazeboDiscovery, ConnectsToTcpAddressesOnly) {
  EXPECT_TRUE(is_tcp_endpoint("tcp://10.0.0.1:1"));
  for (const char* wrong :
       {"", "ipc:///tmp/a", "tcp://localhost:80", "tcp://10.0.0.1", "tcp://10.0.0.1:", "tcp://10.0.0.1:0",
        "tcp://10.0.0.1:70000", "tcp://10.0.0.1:80/", "tcp://*:80", "tcp://10.0.0.1:80 "})
    EXPECT_FALSE(is_tcp_endpoint(wrong)) << wrong;
}

TEST(GazeboDirectory, OnePartitionIsKept) {
  Directory directory("test");
  EXPECT_TRUE(directory.take(decoded(kAdvertiseTopic), true, 0));
  EXPECT_FALSE(directory.take(decoded(kAdvertiseTopic), true, 0));  // again
  EXPECT_TRUE(directory.take(decoded(kAdvertiseService), true, 0));
  EXPECT_EQ(directory.services("/world/demo/scene/info").size(), 1u);
  EXPECT_EQ(directory.publishers("/world/demo/scene/info").size(), 0u);
  EXPECT_EQ(directory.names(), (std::set<std::string>{"/world/demo/scene/info", "/world/other/pose/info"}));
  Directory other("mine");
  EXPECT_FALSE(other.take(decoded(kAdvertiseTopic), true, 0));
  EXPECT_EQ(other.other_partitions(), (std::set<std::string>{"test"}));
}

TEST(GazeboDirectory, GivesUpSilentProcesses) {
  Directory directory("test");
  directory.take(decoded(kAdvertiseTopic), true, 0);
  DiscoveryMessage heartbeat = decoded(kHeartbeat);
  heartbeat.process_uuid = decoded(kAdvertiseTopic).process_uuid;
  directory.take(heartbeat, true, Directory::kSilence_ns);
  EXPECT_TRUE(directory.take_gone(2 * Directory::kSilence_ns).empty());
  EXPECT_EQ(directory.take_gone(2 * Directory::kSilence_ns + 1),
            std::vector<std::string>{heartbeat.process_uuid});
  EXPECT_TRUE(directory.names().empty());
  directory.take(decoded(kAdvertiseTopic), true, 0);
  heartbeat.type = DiscoveryType::bye;
  EXPECT_TRUE(directory.take(heartbeat, true, 1));
  EXPECT_EQ(directory.take_gone(1).size(), 1u);
}

TEST(GazeboDirectory, ChangesMakeVersions) {
  Directory directory("test");
  DiscoveryMessage message = decoded(kAdvertiseTopic);
  uint64_t version = directory.version();
  const auto changes = [&] {
    const uint64_t before = std::exchange(version, directory.version());
    return version != before;
  };
  directory.take(decoded(kHeartbeat), true, 0);
  EXPECT_FALSE(changes());
  directory.take(message, true, 0);
  EXPECT_TRUE(changes());
  directory.take(message, true, 1);
  EXPECT_FALSE(changes());
  message.type = DiscoveryType::unadvertise;
  directory.take(message, true, 2);
  EXPECT_TRUE(changes());
  directory.take(message, true, 3);
  EXPECT_FALSE(changes());
  directory.take(decoded(kAdvertiseService), true, 4);
  EXPECT_TRUE(changes());
  EXPECT_FALSE(directory.take_gone(2 * Directory::kSilence_ns).empty());
  EXPECT_TRUE(changes());
  EXPECT_TRUE(directory.take_gone(3 * Directory::kSilence_ns).empty());
  EXPECT_FALSE(changes());
}

TEST(GazeboDirectory, TrustsProcessesAboutThemselvesOnly) {
  Directory directory("test");
  DiscoveryMessage message = decoded(kAdvertiseTopic);
  message.process_uuid = "another";
  EXPECT_FALSE(directory.take(message, true, 0));
  message = decoded(kAdvertiseTopic);
  message.advertisement->scope = 1;
  EXPECT_FALSE(directory.take(message, false, 0));  // of another host
  message.version = kWireVersionStatistics;
  EXPECT_FALSE(directory.take(message, true, 0));
  EXPECT_TRUE(directory.has_statistics_peers());
}

TEST(GazeboDirectory, IsBounded) {
  Directory directory("test");
  DiscoveryMessage message = decoded(kAdvertiseTopic);
  size_t taken = 0;
  for (size_t i = 0; i < 3 * Directory::kMaxPublishers; ++i) {
    message.process_uuid = message.advertisement->process_uuid = "p" + std::to_string(i % 1000);
    message.advertisement->topic = "@/test@/t" + std::to_string(i);
    taken += directory.take(message, true, 0);
  }
  EXPECT_LE(taken, Directory::kMaxPublishers);
  EXPECT_EQ(taken, directory.names().size());
  EXPECT_EQ(directory.peers(), Directory::kMaxPeers);
}

}  // namespace
}  // namespace fire3dv::gazebo
