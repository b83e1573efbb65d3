// Directory of the publishers and services that peers have announced. Peers that are silent for three seconds
// are given up. Bounded: hostile peers cannot grow it without limit. No sockets; times are given.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "adapters/gazebo/wire/discovery.h"

namespace fire3dv::gazebo {

class Directory {
 public:
  static constexpr int64_t kSilence_ns = 3'000'000'000;
  static constexpr size_t kMaxPeers = 256;
  static constexpr size_t kMaxPublishers = 20'000;

  // partition: the one whose publishers are kept; of others only the name is noted.
  explicit Directory(std::string partition) : partition_(std::move(partition)) {}

  // Returns true if the message is news: an unknown publisher, or one that has gone. is_local: sent on this
  // host.
  bool take(const DiscoveryMessage& message, bool is_local, int64_t now_ns);
  // Returns the uuids of processes that have ended or are silent since the last call.
  std::vector<std::string> take_gone(int64_t now_ns);

  // name: without partition.
  std::vector<Advertisement> publishers(std::string_view name) const;
  std::vector<Advertisement> services(std::string_view name) const;
  // Names of topics and services of the partition, without duplicates, sorted.
  std::set<std::string> names() const;

  // Differs after each change of the publishers and services, which are lists of up to thousands.
  uint64_t version() const { return version_; }
  const std::string& partition() const { return partition_; }
  const std::set<std::string>& other_partitions() const { return other_partitions_; }
  size_t peers() const { return last_heard_.size(); }
  bool has_statistics_peers() const { return has_statistics_peers_; }

 private:
  using Key = std::pair<std::string, std::string>;  // process and node
  using Publishers = std::map<Key, Advertisement>;
  void remove_process(const std::string& uuid);

  std::string partition_;
  std::map<std::string, int64_t> last_heard_;  // by process
  std::map<std::string, Publishers, std::less<>> topics_, services_;
  size_t count_ = 0;
  uint64_t version_ = 0;
  std::set<std::string> other_partitions_;
  std::vector<std::string> gone_;
  bool has_statistics_peers_ = false;
};

}  // namespace fire3dv::gazebo
