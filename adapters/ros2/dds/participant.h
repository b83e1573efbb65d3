// DDS domain participant with the discovery settings of ROS 2's environment variables.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"

namespace fire3dv::ros2 {

// Owner of a DDS entity: deletes it, and with it the entities that it contains.
class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t handle) : handle_(handle) {}
  ~Entity() {
    if (handle_ > 0) dds_delete(handle_);
  }
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;

  dds_entity_t get() const { return handle_; }
  explicit operator bool() const { return handle_ > 0; }

 private:
  dds_entity_t handle_ = 0;
};

// "DDS: TEXT" for a negative return code.
std::string dds_text(dds_return_t code);

enum class DiscoveryRange {
  subnet,         // default
  localhost,      // ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST: participants of this machine, any interface
  loopback_only,  // ROS_LOCALHOST_ONLY=1 (Humble): interface lo
  off             // ROS_AUTOMATIC_DISCOVERY_RANGE=OFF: finds nobody
};

struct DomainSettings {
  uint32_t domain_id = 0;  // 0 to 232
  DiscoveryRange range = DiscoveryRange::subnet;
  std::vector<std::string> static_peers;  // host names or addresses
  std::string cyclonedds_uri;             // appended to the configuration, so that it wins
};

using GetEnv = std::function<const char*(const char*)>;

// Settings of ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_STATIC_PEERS and
// CYCLONEDDS_URI. `domain_id` replaces ROS_DOMAIN_ID. Errors name the variable and its valid values.
Result<DomainSettings> domain_settings(const GetEnv& get_env, std::optional<uint32_t> domain_id = {});

// Configuration of Cyclone DDS for these settings, as XML: discovery that meets both DDS libraries of ROS 2
// in all their settings where one can, large messages and fragments, and a large receive buffer.
std::string cyclonedds_configuration(const DomainSettings& settings);

// For messages: "domain 0, range subnet, interfaces eth0 10.0.0.2, lo 127.0.0.1".
std::string domain_text(const DomainSettings& settings);

// One process opens a domain once at a time. Thread-safe, as Cyclone's entities are.
class Participant {
 public:
  static Result<std::unique_ptr<Participant>> open(DomainSettings settings);

  dds_entity_t get() const { return participant_.get(); }
  const DomainSettings& settings() const { return settings_; }

 private:
  Participant(DomainSettings settings, Entity domain, Entity participant)
      : settings_(std::move(settings)), domain_(std::move(domain)), participant_(std::move(participant)) {}

  DomainSettings settings_;
  Entity domain_;
  Entity participant_;  // deleted before its domain
};

}  // namespace fire3dv::ros2
