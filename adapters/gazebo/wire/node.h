// Participant of Gazebo Transport: discovery, subscriptions, service requests and publications, over UDP and
// ZeroMQ, without Gazebo's libraries. One thread. No call blocks except wait(). Peers are untrusted: sizes
// and counts are limited, and a slow reader here never delays a publisher.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "adapters/gazebo/wire/directory.h"
#include "adapters/gazebo/wire/discovery_socket.h"
#include "base/error.h"

namespace fire3dv::gazebo {

struct NodeOptions {
  std::string partition;            // empty: HOST:USER
  std::string ip;                   // address of this host to use alone; empty: all interfaces
  std::vector<std::string> relays;  // hosts that multicast does not reach
  std::string username, password;   // both empty: none
};

// Options from the environment: GZ_ or IGN_ PARTITION, IP, RELAY, TRANSPORT_USERNAME and TRANSPORT_PASSWORD.
NodeOptions options_of_environment();
// HOST:USER, the partition of Gazebo Transport without a setting.
std::string default_partition();

struct Message {
  std::string name;  // of the topic, without partition
  std::string type;
  std::vector<std::byte> data;
};

struct Response {
  uint64_t request = 0;
  bool is_success = false;
  std::vector<std::byte> data;
};

class Node {
 public:
  static constexpr int64_t kMaxMessageBytes = int64_t{256} << 20;

  static Result<std::unique_ptr<Node>> open(const NodeOptions& options);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  // Waits for network events, at most this long, and processes discovery. Returns uuids of processes that
  // ended.
  std::vector<std::string> wait(int timeout_ms);

  const Directory& directory() const { return directory_; }
  const std::vector<std::string>& interfaces() const { return interfaces_; }

  // Receives this publisher's messages. Repeated calls are cheap.
  void subscribe(const Advertisement& publisher);
  // Ends all subscriptions to this process.
  void unsubscribe(const std::string& process_uuid);
  // True once a publisher has refused a connection: user name or password differ.
  bool was_refused() const { return was_refused_; }
  // The oldest message that has arrived.
  std::optional<Message> next_message();

  // Sends a request to a service. Its id comes back with the response; a lost request has none.
  Result<uint64_t> request(const Advertisement& service, std::span<const std::byte> data);
  std::optional<Response> next_response();

  // Announces a topic of this node. publish() drops messages of a topic for subscribers that do not keep up
  // with it.
  Result<void> advertise(std::string_view name, std::string_view type);
  bool is_advertised(std::string_view name) const { return published_.contains(name); }
  bool has_subscribers(std::string_view name) const;
  void publish(std::string_view name, std::span<const std::byte> data);

 private:
  struct Socket;
  struct Published {
    Advertisement advertisement;
    std::unique_ptr<Socket> socket;
    std::set<std::string> subscribed_prefixes;  // of the topic
  };
  explicit Node(const NodeOptions& options);
  Result<void> open_sockets();
  void send(DiscoverySocket& socket, DiscoveryMessage message) const;
  void receive_discovery(DiscoverySocket& socket);
  void send_heartbeats();
  void read_subscriptions();
  // Endpoint of responses_ for a service at this endpoint.
  Result<std::string> response_endpoint(const std::string& service);

  NodeOptions options_;
  std::vector<std::string> interfaces_;
  std::string host_ip_, process_uuid_, node_uuid_;
  Directory directory_;
  std::optional<DiscoverySocket> messages_, services_;
  std::unique_ptr<Socket> subscriber_, monitor_, responses_;
  bool was_refused_ = false;
  std::map<uint64_t, std::unique_ptr<Socket>> requests_;     // open requests; the oldest are given up
  std::map<std::string, std::string> response_endpoints_;    // by address of this host
  std::map<std::string, int> connections_;                   // subscriptions by address
  std::map<std::string, Advertisement> subscriptions_;       // by topic and process
  std::map<std::string, Published, std::less<>> published_;  // by name
  uint64_t last_request_ = 0;
  int64_t next_heartbeat_ns_ = 0;
};

}  // namespace fire3dv::gazebo
