#include "adapters/gazebo/wire/directory.h"

#include <iterator>
#include <optional>

namespace fire3dv::gazebo {
namespace {

constexpr size_t kMaxOtherPartitions = 32;  // for messages

}  // namespace

void Directory::remove_process(const std::string& uuid) {
  for (auto* map : {&topics_, &services_}) {
    for (auto topic = map->begin(); topic != map->end();) {
      const size_t erased =
          std::erase_if(topic->second, [&](const auto& entry) { return entry.first.first == uuid; });
      count_ -= erased;
      version_ += erased;
      topic = topic->second.empty() ? map->erase(topic) : std::next(topic);
    }
  }
}

bool Directory::take(const DiscoveryMessage& message, bool is_local, int64_t now_ns) {
  if (message.version == kWireVersionStatistics) has_statistics_peers_ = true;
  if (message.version != kWireVersion) return false;
  if (message.type == DiscoveryType::bye) {
    if (last_heard_.erase(message.process_uuid) == 0) return false;
    remove_process(message.process_uuid);
    gone_.push_back(message.process_uuid);
    return true;
  }
  const auto heard = last_heard_.find(message.process_uuid);
  if (heard == last_heard_.end()) {
    if (last_heard_.size() >= kMaxPeers) return false;
    last_heard_.emplace(message.process_uuid, now_ns);
  } else {
    heard->second = now_ns;
  }
  if (message.type != DiscoveryType::advertise && message.type != DiscoveryType::unadvertise) return false;
  const Advertisement& advertisement = *message.advertisement;
  // A process speaks for itself only.
  if (advertisement.process_uuid != message.process_uuid) return false;
  const std::optional<QualifiedName> name = split_qualified_name(advertisement.topic);
  if (!name) return false;
  if (name->partition != partition_) {
    if (other_partitions_.size() < kMaxOtherPartitions) other_partitions_.insert(name->partition);
    return false;
  }
  auto& map = advertisement.is_service ? services_ : topics_;
  const Key key(advertisement.process_uuid, advertisement.node_uuid);
  if (message.type == DiscoveryType::unadvertise) {
    const auto topic = map.find(name->name);
    if (topic == map.end() || topic->second.erase(key) == 0) return false;
    --count_;
    ++version_;
    if (topic->second.empty()) map.erase(topic);
    return true;
  }
  if (advertisement.scope == 0 || (advertisement.scope == 1 && !is_local)) return false;
  if (!is_tcp_endpoint(advertisement.address)) return false;
  if (const auto topic = map.find(name->name); topic != map.end() && topic->second.contains(key))
    return false;
  if (count_ >= kMaxPublishers) return false;
  map[name->name].emplace(key, advertisement);
  ++count_;
  ++version_;
  return true;
}

std::vector<std::string> Directory::take_gone(int64_t now_ns) {
  for (auto peer = last_heard_.begin(); peer != last_heard_.end();) {
    if (now_ns - peer->second <= kSilence_ns) {
      ++peer;
      continue;
    }
    remove_process(peer->first);
    gone_.push_back(peer->first);
    peer = last_heard_.erase(peer);
  }
  return std::exchange(gone_, {});
}

namespace {

template <typename Map>
std::vector<Advertisement> entries(const Map& map, std::string_view name) {
  std::vector<Advertisement> found;
  if (const auto topic = map.find(name); topic != map.end())
    for (const auto& [key, advertisement] : topic->second) found.push_back(advertisement);
  return found;
}

}  // namespace

std::vector<Advertisement> Directory::publishers(std::string_view name) const {
  return entries(topics_, name);
}

std::vector<Advertisement> Directory::services(std::string_view name) const {
  return entries(services_, name);
}

std::set<std::string> Directory::names() const {
  std::set<std::string> names;
  for (const auto* map : {&topics_, &services_})
    for (const auto& [name, publishers] : *map) names.insert(name);
  return names;
}

}  // namespace fire3dv::gazebo
