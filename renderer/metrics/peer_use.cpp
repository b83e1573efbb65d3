#include "renderer/metrics/peer_use.h"

#include <algorithm>
#include <set>
#include <utility>

#include "protocol/wire/check.h"

namespace fire3dv::metrics {
namespace {

// Largest used fraction of a limit; peers with refusals rank above all others.
double rank_of(const PeerUse& peer, const PeerLimits& limits) {
  double rank = 0;
  for (size_t i = 0; i < kResourceCount; ++i) {
    if (peer.refused[i] > 0) rank = std::max(rank, 1.0);
    if (limits.per_peer[i] > 0)
      rank = std::max(rank, static_cast<double>(peer.used[i]) / static_cast<double>(limits.per_peer[i]));
  }
  return rank;
}

void keep_largest(std::vector<PeerUse>& peers, const PeerLimits& limits) {
  if (peers.size() <= kMaxListedPeers) return;
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < peers.size(); ++i) order.emplace_back(-rank_of(peers[i], limits), i);
  std::ranges::sort(order);
  order.resize(kMaxListedPeers);
  std::vector<PeerUse> largest;
  for (const auto& [rank, i] : order) largest.push_back(std::move(peers[i]));
  peers = std::move(largest);
}

// Makes names unique: two samples of a family must not have the same labels.
void name_apart(std::vector<PeerUse>& peers) {
  std::set<std::string> names;
  for (PeerUse& peer : peers) {
    const std::string name = wire::printable(peer.peer);
    peer.peer = name;
    for (uint32_t number = 2; !names.insert(peer.peer).second; ++number)
      peer.peer = name + " #" + std::to_string(number);
  }
}

}  // namespace

void write_peer_use(Exposition& page, const PeerLimits& limits, std::vector<PeerUse> peers) {
  page.family("fire3dv_peers", "gauge", "Peers that have a budget.");
  page.sample({}, uint64_t{peers.size()});
  page.family("fire3dv_peer_limit", "gauge", "Limit of one peer, in bytes or objects.");
  for (const ResourceInfo& resource : resource_table())
    page.sample({{"resource", resource.name}}, limits.of(resource.resource));
  keep_largest(peers, limits);
  name_apart(peers);
  page.family("fire3dv_peer_use", "gauge",
              "Resources that the renderer holds for a peer, in bytes or objects.");
  for (const PeerUse& peer : peers) {
    for (size_t i = 0; i < kResourceCount; ++i)
      page.sample({{"peer", peer.peer}, {"stream", peer.stream}, {"resource", resource_table()[i].name}},
                  peer.used[i]);
  }
  page.family("fire3dv_peer_refusals_total", "counter", "Values and objects refused by a limit.");
  for (const PeerUse& peer : peers) {
    for (size_t i = 0; i < kResourceCount; ++i)
      page.sample({{"peer", peer.peer}, {"resource", resource_table()[i].name}}, peer.refused[i]);
  }
}

}  // namespace fire3dv::metrics
