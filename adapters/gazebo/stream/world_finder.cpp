#include "adapters/gazebo/stream/world_finder.h"

#include <algorithm>
#include <string_view>

#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::gazebo {
namespace {

template <typename List>
std::string list_of(const List& names, bool quoted) {
  constexpr size_t kMaxNames = 8;
  std::string text;
  size_t count = 0;
  for (const std::string& name : names) {
    if (count++ == kMaxNames) return text + ", ...";
    text += (text.empty() ? "" : ", ") + (quoted ? quote(name) : name);
  }
  return text;
}

}  // namespace

std::vector<std::string> world_names(const Directory& directory) {
  constexpr std::string_view kBefore = "/world/", kBehind = "/scene/info";
  std::vector<std::string> worlds;
  for (const std::string& name : directory.names()) {
    if (!name.starts_with(kBefore) || !name.ends_with(kBehind) ||
        name.size() <= kBefore.size() + kBehind.size())
      continue;
    const std::string world = name.substr(kBefore.size(), name.size() - kBefore.size() - kBehind.size());
    if (world.find('/') == world.npos && !directory.services(name).empty()) worlds.push_back(world);
  }
  return worlds;
}

Result<std::optional<std::string>> choose_world(const Directory& directory, const std::string& wanted) {
  const std::vector<std::string> worlds = world_names(directory);
  if (!wanted.empty()) {
    if (std::find(worlds.begin(), worlds.end(), wanted) == worlds.end()) return std::optional<std::string>();
    return std::optional(wanted);
  }
  if (worlds.size() > 1)
    return Error{"there are " + std::to_string(worlds.size()) +
                 " worlds: choose one with --world: " + list_of(worlds, true)};
  if (worlds.empty()) return std::optional<std::string>();
  return std::optional(worlds.front());
}

std::string missing_world_advice(const Directory& directory, const std::string& wanted,
                                 const std::vector<std::string>& interfaces) {
  std::string text = wanted.empty() ? "no Gazebo world" : "no Gazebo world " + quote(wanted);
  text += " in partition " + quote(directory.partition()) + " yet; looked on " + list_of(interfaces, false) +
          " (multicast " + kMulticastGroup + ", UDP ports " + std::to_string(kMessagePort) + " and " +
          std::to_string(kServicePort) + ")";
  if (const std::vector<std::string> worlds = world_names(directory); !worlds.empty())
    return text + "; worlds seen: " + list_of(worlds, true) + ": choose one with --world";
  if (!directory.other_partitions().empty())
    return text + "; other partitions seen: " + list_of(directory.other_partitions(), true) +
           ": set GZ_PARTITION, or --partition";
  if (directory.has_statistics_peers())
    return text +
           "; a peer with GZ_TRANSPORT_TOPIC_STATISTICS=1 was seen, which others cannot hear: unset it there";
  if (directory.peers() > 0)
    return text + "; " + counted(directory.peers(), "peer") +
           " of Gazebo Transport seen, none with a scene: does the world have the SceneBroadcaster system?";
  return text +
         "; no process of Gazebo Transport was seen: start Gazebo (gz sim WORLD.sdf), or, on a network "
         "without multicast, name its host with --peer; Gazebo with GZ_TRANSPORT_IMPLEMENTATION=zenoh is out "
         "of reach";
}

}  // namespace fire3dv::gazebo
