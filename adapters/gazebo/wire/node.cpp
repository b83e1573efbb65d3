#include "adapters/gazebo/wire/node.h"

#include <poll.h>
#include <pwd.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "base/clock.h"
#include "base/numbers.h"
#include "base/random.h"
#include "base/text.h"

namespace fire3dv::gazebo {
namespace {

constexpr size_t kMaxParts = 16;             // of one message
constexpr size_t kMaxRequests = 8;           // open at one time
constexpr int kMaxDatagramsAtOnce = 1000;    // so that a flood does not starve the rest
constexpr size_t kMaxPublishedTopics = 256;  // sockets
constexpr int kMaxPartsAtOnce = 1000;        // messages of one call: a flood of invalid ones does not hold it
constexpr int64_t kMaxSubscriptionBytes = 8192;
constexpr int kMaxQueuedMessages = 100, kMaxQueuedResponses = 8;  // of one connection
constexpr int64_t kHeartbeat_ns = kSecondNs;

std::string environment(const char* name) {
  for (const char* prefix : {"GZ_", "IGN_"}) {
    const char* value = std::getenv((std::string(prefix) + name).c_str());
    if (value && *value) return value;
  }
  return "";
}

// Random version 4 UUID.
std::string make_uuid() {
  const uint64_t high = random_id(), low = random_id();
  char text[40];
  std::snprintf(text, sizeof text, "%08x-%04x-4%03x-%04x-%012llx", static_cast<unsigned>(high >> 32),
                static_cast<unsigned>(high >> 16 & 0xffff), static_cast<unsigned>(high & 0xfff),
                static_cast<unsigned>(0x8000 | (low >> 48 & 0x3fff)),
                static_cast<unsigned long long>(low & 0xffffffffffffull));
  return text;
}

void* context() {
  static void* const shared = zmq_ctx_new();
  return shared;
}

}  // namespace

NodeOptions options_of_environment() {
  NodeOptions options;
  options.partition = environment("PARTITION");
  options.ip = environment("IP");
  std::string relays = environment("RELAY");
  for (size_t begin = 0; begin < relays.size();) {
    const size_t end = std::min(relays.find(':', begin), relays.size());
    if (end > begin) options.relays.push_back(relays.substr(begin, end - begin));
    begin = end + 1;
  }
  options.username = environment("TRANSPORT_USERNAME");
  options.password = environment("TRANSPORT_PASSWORD");
  return options;
}

std::string default_partition() {
  char host[256] = "";
  (void)::gethostname(host, sizeof host - 1);
  const passwd* user = ::getpwuid(::getuid());
  return std::string(host) + ":" + (user ? user->pw_name : "");
}

// ZeroMQ socket.
struct Node::Socket {
  explicit Socket(int type) : handle(zmq_socket(context(), type)) {
    set(ZMQ_LINGER, 0);
    set(ZMQ_MAXMSGSIZE, type == ZMQ_XPUB ? kMaxSubscriptionBytes : kMaxMessageBytes);
    set(ZMQ_RCVHWM, type == ZMQ_ROUTER ? kMaxQueuedResponses : kMaxQueuedMessages);
  }
  ~Socket() {
    if (handle) zmq_close(handle);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  template <typename T>
  void set(int option, T value) {
    (void)zmq_setsockopt(handle, option, &value, sizeof value);
  }
  void set_text(int option, std::string_view text) {
    (void)zmq_setsockopt(handle, option, text.data(), text.size());
  }
  Result<std::string> bind(const std::string& ip) {
    const std::string any = "tcp://" + ip + ":*";
    if (!handle || zmq_bind(handle, any.c_str()) != 0)
      return Error{"cannot listen on " + ip + ": " + zmq_strerror(zmq_errno()) +
                   " (--ip selects an address)"};
    char endpoint[256] = "";
    size_t size = sizeof endpoint;
    if (zmq_getsockopt(handle, ZMQ_LAST_ENDPOINT, endpoint, &size) != 0)
      return Error{std::string("cannot read the address of a socket: ") + zmq_strerror(zmq_errno())};
    return std::string(endpoint);
  }
  bool send(std::span<const std::string_view> parts) {
    for (size_t i = 0; i < parts.size(); ++i) {
      const int flags = ZMQ_DONTWAIT | (i + 1 < parts.size() ? ZMQ_SNDMORE : 0);
      if (zmq_send(handle, parts[i].data(), parts[i].size(), flags) < 0) return false;
    }
    return true;
  }
  // Returns a whole message of at most kMaxParts parts; nullopt: none is waiting.
  std::optional<std::vector<std::string>> receive() {
    std::vector<std::string> parts;
    bool more = true;
    for (bool is_first = true; more; is_first = false) {
      zmq_msg_t message;
      zmq_msg_init(&message);
      int received = -1;
      do {
        received = zmq_msg_recv(&message, handle, is_first ? ZMQ_DONTWAIT : 0);
      } while (received < 0 && zmq_errno() == EINTR);
      if (received < 0) {
        zmq_msg_close(&message);
        return std::nullopt;
      }
      if (parts.size() < kMaxParts)
        parts.emplace_back(static_cast<const char*>(zmq_msg_data(&message)), zmq_msg_size(&message));
      more = zmq_msg_more(&message) != 0;
      zmq_msg_close(&message);
    }
    return parts;
  }

  void* handle;
};

namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

std::string_view view_of(std::span<const std::byte> data) {
  return {reinterpret_cast<const char*>(data.data()), data.size()};
}

}  // namespace

Node::Node(const NodeOptions& options)
    : options_(options),
      process_uuid_(make_uuid()),
      node_uuid_(make_uuid()),
      directory_(options.partition.empty() ? default_partition() : options.partition) {}

Node::~Node() {
  if (!messages_ || !services_) return;
  for (const auto& [key, publisher] : subscriptions_) {
    DiscoveryMessage message;
    message.type = DiscoveryType::end_connection;
    message.advertisement = publisher;
    message.advertisement->ctrl = publisher.process_uuid;
    message.advertisement->process_uuid = process_uuid_;
    message.advertisement->node_uuid = node_uuid_;
    send(*messages_, std::move(message));
  }
  DiscoveryMessage bye;
  bye.type = DiscoveryType::bye;
  send(*messages_, bye);
  send(*services_, bye);
}

Result<std::unique_ptr<Node>> Node::open(const NodeOptions& options) {
  if (!options.partition.empty() && !is_valid_partition(options.partition))
    return Error{"partition " + quote(options.partition) +
                 " is not valid: no blanks, '@', '~', ':=' or '//'"};
  if (options.username.empty() != options.password.empty())
    return Error{"set both GZ_TRANSPORT_USERNAME and GZ_TRANSPORT_PASSWORD, or neither"};
  std::unique_ptr<Node> node(new Node(options));
  if (Result<void> opened = node->open_sockets(); !opened) return opened.error();
  return node;
}

Result<void> Node::open_sockets() {
  interfaces_ = options_.ip.empty() ? interface_addresses() : std::vector<std::string>{options_.ip};
  host_ip_ = interfaces_.front();
  for (const auto& [socket, port] : {std::pair(&messages_, kMessagePort), {&services_, kServicePort}}) {
    Result<DiscoverySocket> opened = DiscoverySocket::open(port, interfaces_);
    if (!opened) return opened.error();
    *socket = std::move(*opened);
  }
  for (const std::string& host : options_.relays) {
    const Result<std::string> address = resolve_host(host);
    if (!address) return address.error();
    messages_->add_relay(*address);
    services_->add_relay(*address);
  }
  subscriber_ = std::make_unique<Socket>(ZMQ_SUB);
  if (!subscriber_->handle)
    return Error{std::string("cannot open a ZeroMQ socket: ") + zmq_strerror(zmq_errno())};
  if (!options_.username.empty()) {
    subscriber_->set_text(ZMQ_PLAIN_USERNAME, options_.username);
    subscriber_->set_text(ZMQ_PLAIN_PASSWORD, options_.password);
  }
  // Handshakes that fail are not errors of a call.
  const std::string events = "inproc://" + process_uuid_;
  monitor_ = std::make_unique<Socket>(ZMQ_PAIR);
  if (zmq_socket_monitor(subscriber_->handle, events.c_str(),
                         ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) == 0)
    (void)zmq_connect(monitor_->handle, events.c_str());
  responses_ = std::make_unique<Socket>(ZMQ_ROUTER);
  responses_->set_text(ZMQ_ROUTING_ID, process_uuid_);
  return {};
}

Result<std::string> Node::response_endpoint(const std::string& service) {
  constexpr size_t kScheme = 6;  // tcp://
  std::string ip = options_.ip;
  if (ip.empty()) ip = local_address_to(service.substr(kScheme, service.rfind(':') - kScheme));
  if (ip.empty()) ip = host_ip_;
  std::string& endpoint = response_endpoints_[ip];
  if (endpoint.empty()) {
    Result<std::string> bound = responses_->bind(ip);
    if (!bound) return bound;
    endpoint = std::move(*bound);
  }
  return endpoint;
}

void Node::send(DiscoverySocket& socket, DiscoveryMessage message) const {
  message.process_uuid = process_uuid_;
  socket.send_to_group(encode_discovery(message));
  message.is_relay = true;
  socket.send_to_relays(encode_discovery(message));
}

void Node::receive_discovery(DiscoverySocket& socket) {
  for (int i = 0; i < kMaxDatagramsAtOnce; ++i) {
    const std::optional<DiscoverySocket::Datagram> datagram = socket.receive();
    if (!datagram) return;
    std::optional<DiscoveryMessage> message = decode_discovery(datagram->bytes);
    if (!message || message->process_uuid == process_uuid_) continue;
    if (message->is_relay) {
      // Unicast reaches one process of this host only: hand it on to the others, as Gazebo's library does.
      socket.add_relay(datagram->from);
      DiscoveryMessage forwarded = *message;
      forwarded.is_relay = false;
      forwarded.is_no_relay = true;
      socket.send_to_group(encode_discovery(forwarded));
    }
    const bool is_local =
        datagram->from.starts_with("127.") ||
        std::find(interfaces_.begin(), interfaces_.end(), datagram->from) != interfaces_.end();
    if (message->type == DiscoveryType::subscribe && message->version == kWireVersion &&
        !published_.empty()) {
      const std::optional<QualifiedName> name = split_qualified_name(message->topic);
      const auto mine =
          name && name->partition == directory_.partition() ? published_.find(name->name) : published_.end();
      if (mine != published_.end()) {
        DiscoveryMessage answer;
        answer.type = DiscoveryType::advertise;
        answer.advertisement = mine->second.advertisement;
        send(*messages_, std::move(answer));
      }
    }
    directory_.take(*message, is_local, monotonic_ns());
  }
}

void Node::send_heartbeats() {
  const int64_t now_ns = monotonic_ns();
  if (now_ns < next_heartbeat_ns_) return;
  next_heartbeat_ns_ = now_ns + kHeartbeat_ns;
  DiscoveryMessage heartbeat;
  heartbeat.type = DiscoveryType::heartbeat;
  send(*messages_, heartbeat);
  send(*services_, heartbeat);
  for (const auto& [name, topic] : published_) {
    DiscoveryMessage message;
    message.type = DiscoveryType::advertise;
    message.advertisement = topic.advertisement;
    send(*messages_, std::move(message));
  }
}

std::vector<std::string> Node::wait(int timeout_ms) {
  send_heartbeats();
  const auto until_heartbeat_ms = (next_heartbeat_ns_ - monotonic_ns()) / kMillisecondNs + 1;
  std::vector<zmq_pollitem_t> items = {{nullptr, messages_->descriptor(), ZMQ_POLLIN, 0},
                                       {nullptr, services_->descriptor(), ZMQ_POLLIN, 0},
                                       {subscriber_->handle, 0, ZMQ_POLLIN, 0},
                                       {responses_->handle, 0, ZMQ_POLLIN, 0}};
  for (const auto& [name, topic] : published_) items.push_back({topic.socket->handle, 0, ZMQ_POLLIN, 0});
  (void)zmq_poll(items.data(), static_cast<int>(items.size()),
                 static_cast<long>(std::clamp<int64_t>(until_heartbeat_ms, 0, timeout_ms)));
  receive_discovery(*messages_);
  receive_discovery(*services_);
  read_subscriptions();
  for (int i = 0; i < kMaxPartsAtOnce && monitor_->receive(); ++i) was_refused_ = true;
  return directory_.take_gone(monotonic_ns());
}

void Node::subscribe(const Advertisement& publisher) {
  const std::string key = publisher.topic + "\n" + publisher.process_uuid;
  if (subscriptions_.contains(key)) return;
  if (connections_[publisher.address]++ == 0)
    (void)zmq_connect(subscriber_->handle, publisher.address.c_str());
  subscriber_->set_text(ZMQ_SUBSCRIBE, publisher.topic);
  subscriptions_.emplace(key, publisher);
  // Publishers send only to subscribers that they know.
  DiscoveryMessage message;
  message.type = DiscoveryType::new_connection;
  message.advertisement = publisher;
  message.advertisement->ctrl = publisher.process_uuid;
  message.advertisement->process_uuid = process_uuid_;
  message.advertisement->node_uuid = node_uuid_;
  send(*messages_, std::move(message));
}

void Node::unsubscribe(const std::string& process_uuid) {
  for (auto entry = subscriptions_.begin(); entry != subscriptions_.end();) {
    const Advertisement& publisher = entry->second;
    if (publisher.process_uuid != process_uuid) {
      ++entry;
      continue;
    }
    (void)zmq_setsockopt(subscriber_->handle, ZMQ_UNSUBSCRIBE, publisher.topic.data(),
                         publisher.topic.size());
    if (--connections_[publisher.address] == 0) {
      (void)zmq_disconnect(subscriber_->handle, publisher.address.c_str());
      connections_.erase(publisher.address);
    }
    entry = subscriptions_.erase(entry);
  }
}

std::optional<Message> Node::next_message() {
  for (int i = 0; i < kMaxPartsAtOnce; ++i) {
    auto parts = subscriber_->receive();
    if (!parts) break;
    if (parts->size() < 4) continue;
    const std::optional<QualifiedName> name = split_qualified_name((*parts)[0]);
    if (!name || name->partition != directory_.partition()) continue;
    return Message{name->name, std::move((*parts)[3]), bytes_of((*parts)[2])};
  }
  return std::nullopt;
}

Result<uint64_t> Node::request(const Advertisement& service, std::span<const std::byte> data) {
  const Result<std::string> address = response_endpoint(service.address);
  if (!address) return address.error();
  // A dealer queues the request until it is connected; the service's router sees the same parts as from a
  // router.
  auto socket = std::make_unique<Socket>(ZMQ_DEALER);
  if (!socket->handle || zmq_connect(socket->handle, service.address.c_str()) != 0)
    return Error{"cannot connect to " + quote(service.address) + ": " + zmq_strerror(zmq_errno())};
  const uint64_t id = ++last_request_;
  const std::string request_uuid = std::to_string(id);
  const std::string_view parts[] = {
      service.topic, *address,      process_uuid_,        node_uuid_,
      request_uuid,  view_of(data), service.request_type, service.response_type};
  if (!socket->send(parts))
    return Error{"cannot send a request to " + quote(service.address) + ": " + zmq_strerror(zmq_errno())};
  while (requests_.size() >= kMaxRequests) requests_.erase(requests_.begin());
  requests_.emplace(id, std::move(socket));
  return id;
}

std::optional<Response> Node::next_response() {
  for (int i = 0; i < kMaxPartsAtOnce; ++i) {
    auto parts = responses_->receive();
    if (!parts) break;
    // Identity of the service's socket, topic, node, request, data, result.
    if (parts->size() < 6 || (*parts)[2] != node_uuid_) continue;
    const std::optional<uint64_t> id = parse_number<uint64_t>((*parts)[3]);
    if (!id || requests_.erase(*id) == 0) continue;
    return Response{*id, (*parts)[5] == "1", bytes_of((*parts)[4])};
  }
  return std::nullopt;
}

Result<void> Node::advertise(std::string_view name, std::string_view type) {
  if (!options_.username.empty())
    return Error{"topics are not published with GZ_TRANSPORT_USERNAME: unset it, or leave out --camera"};
  if (is_advertised(name)) return {};
  if (published_.size() == kMaxPublishedTopics)
    return Error{"at most " + std::to_string(kMaxPublishedTopics) +
                 " topics are published: choose cameras with --camera"};
  // A queue for each topic: none takes the place of another one's messages.
  auto socket = std::make_unique<Socket>(ZMQ_XPUB);
  socket->set(ZMQ_SNDHWM, 2);
  Result<std::string> address = socket->bind(host_ip_);
  if (!address) return address.error();
  Advertisement advertisement;
  advertisement.topic = qualified_name(directory_.partition(), name);
  advertisement.address = std::move(*address);
  advertisement.process_uuid = process_uuid_;
  advertisement.node_uuid = node_uuid_;
  advertisement.message_type = type;
  published_.emplace(std::string(name), Published{advertisement, std::move(socket), {}});
  DiscoveryMessage message;
  message.type = DiscoveryType::advertise;
  message.advertisement = std::move(advertisement);
  send(*messages_, std::move(message));
  return {};
}

void Node::read_subscriptions() {
  for (auto& [name, topic] : published_) {
    for (int i = 0; i < kMaxPartsAtOnce; ++i) {
      auto parts = topic.socket->receive();
      if (!parts) break;
      const std::string& text = parts->front();
      if (text.empty()) continue;
      // Subscribers ask all publishers that they know for each prefix.
      const std::string prefix = text.substr(1);
      if (!topic.advertisement.topic.starts_with(prefix)) continue;
      if (text[0] == 0) topic.subscribed_prefixes.erase(prefix);
      if (text[0] == 1) topic.subscribed_prefixes.insert(prefix);
    }
  }
}

bool Node::has_subscribers(std::string_view name) const {
  const auto published = published_.find(name);
  return published != published_.end() && !published->second.subscribed_prefixes.empty();
}

void Node::publish(std::string_view name, std::span<const std::byte> data) {
  const auto published = published_.find(name);
  if (published == published_.end()) return;
  const Advertisement& topic = published->second.advertisement;
  const std::string_view parts[] = {topic.topic, topic.address, view_of(data), topic.message_type};
  (void)published->second.socket->send(parts);
}

}  // namespace fire3dv::gazebo
