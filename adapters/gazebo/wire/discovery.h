// Discovery messages of Gazebo Transport: UDP datagrams that announce topics and services. Encoder and
// decoder without sockets. Datagrams are untrusted: lengths and addresses are checked, texts are bounded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fire3dv::gazebo {

constexpr const char* kMulticastGroup = "239.255.0.7";
constexpr uint16_t kMessagePort = 10317, kServicePort = 10318;
constexpr uint32_t kWireVersion = 10;  // of all releases from Fortress to Jetty
constexpr uint32_t kWireVersionStatistics =
    110;  // with GZ_TRANSPORT_TOPIC_STATISTICS; both ignore each other

enum class DiscoveryType : uint8_t {
  advertise = 1,
  subscribe = 2,
  unadvertise = 3,
  heartbeat = 4,
  bye = 5,
  new_connection = 6,
  end_connection = 7,
};

// Publisher of a topic, or provider of a service.
struct Advertisement {
  std::string topic;    // fully qualified: @/PARTITION@/NAME
  std::string address;  // ZeroMQ endpoint: tcp://IP:PORT
  std::string process_uuid;
  std::string node_uuid;
  int scope = 2;  // 0 process, 1 host, 2 all
  bool is_service = false;
  std::string ctrl, message_type;  // of topics
  bool throttled = false;
  uint64_t messages_per_second = 0;
  std::string socket_id, request_type, response_type;  // of services
};

struct DiscoveryMessage {
  uint32_t version = kWireVersion;
  DiscoveryType type = DiscoveryType::heartbeat;
  std::string process_uuid;  // of the sender
  bool is_relay = false, is_no_relay = false;
  std::string topic;                           // of subscribe
  std::optional<Advertisement> advertisement;  // of advertise, unadvertise, new_connection, end_connection
};

// Nullopt: not a valid datagram of a known type.
std::optional<DiscoveryMessage> decode_discovery(std::span<const std::byte> datagram);
// Empty: the message does not fit into a datagram.
std::vector<std::byte> encode_discovery(const DiscoveryMessage& message);

// Splits @/PARTITION@/NAME. Nullopt: not a fully qualified name.
struct QualifiedName {
  std::string partition;  // without slashes at its ends
  std::string name;       // begins with a slash
};
std::optional<QualifiedName> split_qualified_name(std::string_view text);
std::string qualified_name(std::string_view partition, std::string_view name);

// True for tcp://IPv4:PORT, the only kind of endpoint that peers announce.
bool is_tcp_endpoint(std::string_view address);

// Partitions and names as Gazebo Transport accepts them: not empty, without blanks, '@', '~', ":=" and "//".
bool is_valid_partition(std::string_view text);

}  // namespace fire3dv::gazebo
