#include "adapters/gazebo/wire/discovery.h"

#include <arpa/inet.h>

#include "base/numbers.h"
#include "gazebo.pb.h"

namespace fire3dv::gazebo {
namespace {

constexpr size_t kMaxText = 1024;       // of a name or type; real ones are below 200 bytes
constexpr size_t kMaxDatagram = 65507;  // payload of UDP over IPv4

bool is_text(const std::string& text) {
  return text.size() <= kMaxText && text.find('\0') == std::string::npos;
}

std::optional<Advertisement> read_advertisement(const pb::Discovery::Publisher& from) {
  Advertisement to;
  to.topic = from.topic();
  to.address = from.address();
  to.process_uuid = from.process_uuid();
  to.node_uuid = from.node_uuid();
  to.scope = from.scope();
  if (from.has_msg_pub()) {
    to.ctrl = from.msg_pub().ctrl();
    to.message_type = from.msg_pub().msg_type();
    to.throttled = from.msg_pub().throttled();
    to.messages_per_second = from.msg_pub().msgs_per_sec();
  } else if (from.has_srv_pub()) {
    to.is_service = true;
    to.socket_id = from.srv_pub().socket_id();
    to.request_type = from.srv_pub().request_type();
    to.response_type = from.srv_pub().response_type();
  } else {
    return std::nullopt;
  }
  for (const std::string* text : {&to.topic, &to.address, &to.process_uuid, &to.node_uuid, &to.ctrl,
                                  &to.message_type, &to.socket_id, &to.request_type, &to.response_type})
    if (!is_text(*text)) return std::nullopt;
  if (to.scope < 0 || to.scope > 2 || !split_qualified_name(to.topic)) return std::nullopt;
  return to;
}

void write_advertisement(const Advertisement& from, pb::Discovery::Publisher& to) {
  to.set_topic(from.topic);
  to.set_address(from.address);
  to.set_process_uuid(from.process_uuid);
  to.set_node_uuid(from.node_uuid);
  to.set_scope(from.scope);
  if (from.is_service) {
    pb::Discovery::ServicePublisher& service = *to.mutable_srv_pub();
    service.set_socket_id(from.socket_id);
    service.set_request_type(from.request_type);
    service.set_response_type(from.response_type);
  } else {
    pb::Discovery::MessagePublisher& publisher = *to.mutable_msg_pub();
    publisher.set_ctrl(from.ctrl);
    publisher.set_msg_type(from.message_type);
    publisher.set_throttled(from.throttled);
    publisher.set_msgs_per_sec(from.messages_per_second);
  }
}

bool has_publisher(DiscoveryType type) {
  return type == DiscoveryType::advertise || type == DiscoveryType::unadvertise ||
         type == DiscoveryType::new_connection || type == DiscoveryType::end_connection;
}

}  // namespace

std::optional<DiscoveryMessage> decode_discovery(std::span<const std::byte> datagram) {
  if (datagram.size() < 2 || datagram.size() > kMaxDatagram) return std::nullopt;
  // Little endian on all machines that Gazebo supports.
  const size_t length = std::to_integer<size_t>(datagram[0]) | std::to_integer<size_t>(datagram[1]) << 8;
  if (length + 2 != datagram.size()) return std::nullopt;
  pb::Discovery from;
  if (!from.ParseFromArray(datagram.data() + 2, static_cast<int>(length))) return std::nullopt;
  if (from.type() < 1 || from.type() > 7) return std::nullopt;
  DiscoveryMessage to;
  to.version = from.version();
  to.type = static_cast<DiscoveryType>(from.type());
  to.process_uuid = from.process_uuid();
  to.is_relay = from.flags().relay();
  to.is_no_relay = from.flags().no_relay();
  if (to.process_uuid.empty() || !is_text(to.process_uuid)) return std::nullopt;
  if (to.type == DiscoveryType::subscribe) {
    if (!from.has_sub() || !is_text(from.sub().topic())) return std::nullopt;
    to.topic = from.sub().topic();
  } else if (has_publisher(to.type)) {
    if (!from.has_pub()) return std::nullopt;
    to.advertisement = read_advertisement(from.pub());
    if (!to.advertisement) return std::nullopt;
  }
  return to;
}

std::vector<std::byte> encode_discovery(const DiscoveryMessage& message) {
  pb::Discovery to;
  to.set_version(message.version);
  to.set_process_uuid(message.process_uuid);
  to.set_type(static_cast<int>(message.type));
  if (message.is_relay || message.is_no_relay) {
    to.mutable_flags()->set_relay(message.is_relay);
    to.mutable_flags()->set_no_relay(message.is_no_relay);
  }
  if (message.type == DiscoveryType::subscribe) to.mutable_sub()->set_topic(message.topic);
  if (message.advertisement) write_advertisement(*message.advertisement, *to.mutable_pub());
  const size_t size = to.ByteSizeLong();
  if (size + 2 > kMaxDatagram) return {};
  std::vector<std::byte> datagram(size + 2);
  datagram[0] = static_cast<std::byte>(size & 0xff);
  datagram[1] = static_cast<std::byte>(size >> 8);
  if (!to.SerializeToArray(datagram.data() + 2, static_cast<int>(size))) return {};
  return datagram;
}

std::optional<QualifiedName> split_qualified_name(std::string_view text) {
  if (text.size() < 4 || text.front() != '@') return std::nullopt;
  const size_t second = text.find('@', 1);
  if (second == text.npos) return std::nullopt;
  std::string_view partition = text.substr(1, second - 1), name = text.substr(second + 1);
  if (partition.starts_with('/')) partition.remove_prefix(1);
  if (!name.starts_with('/')) return std::nullopt;
  return QualifiedName{std::string(partition), std::string(name)};
}

std::string qualified_name(std::string_view partition, std::string_view name) {
  std::string text = "@";
  if (!partition.empty()) text += (partition.starts_with('/') ? "" : "/") + std::string(partition);
  text += "@";
  if (!name.starts_with('/')) text += "/";
  return text + std::string(name);
}

bool is_tcp_endpoint(std::string_view address) {
  constexpr std::string_view kScheme = "tcp://";
  if (!address.starts_with(kScheme) || address.size() > 64) return false;
  address.remove_prefix(kScheme.size());
  const size_t colon = address.rfind(':');
  if (colon == address.npos) return false;
  const std::string host(address.substr(0, colon));
  in_addr parsed{};
  if (inet_pton(AF_INET, host.c_str(), &parsed) != 1) return false;
  return parse_number<uint16_t>(address.substr(colon + 1)).value_or(0) != 0;
}

bool is_valid_partition(std::string_view text) {
  return !text.empty() && text.size() <= 1024 && text != "/" && text.find('@') == text.npos &&
         text.find('~') == text.npos && text.find(' ') == text.npos && text.find(":=") == text.npos &&
         text.find("//") == text.npos;
}

}  // namespace fire3dv::gazebo
