// Budget charges for the nodes and assets that a peer adds to the scene, and the scheduling of asset loads
// between peers.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "protocol/base/peer_budget.h"
#include "renderer/scene/cache/scene_file.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::app {

// Resource use of one instance of an asset.
struct AssetSize {
  uint64_t host_bytes = 0;  // decoded asset, counted once for all of its instances
  uint64_t gpu_bytes = 0;
  uint64_t nodes = 0;
  uint64_t path_bytes = 0;                 // paths of its nodes, without prefixes
  uint64_t lights = 0, shadow_lights = 0;  // nodes with such a light
};
AssetSize measure(const scene::LoadedScene& asset);

// Charges of an added node, for its lifetime in the scene.
struct NodeCharges {
  BudgetCharge nodes, lights, shadow_lights, gpu, paths;
  bool casts_shadows = true;  // false: its asset's lights exceed the shadow-lights limit
};
// asset: null for an empty node.
Result<NodeCharges> charge_node(const std::shared_ptr<PeerBudget>& budget, const AssetSize* asset);
// Charges paths; path_bytes includes those of the asset's nodes and all prefixes. Counts several copies: the
// old and the new scene, their name indices, and the build each hold one.
Result<void> charge_paths(NodeCharges& charges, const std::shared_ptr<PeerBudget>& budget,
                          uint64_t path_bytes);

// Load limits of an asset: stricter than for the user's file, and within the peer's budget. `charge` grows
// with the loader's reservations and must outlive the load.
scene::LoadLimits limits_of_asset(const std::shared_ptr<PeerBudget>& budget, BudgetCharge& charge);

// Start-time fair queueing of peers: the waiting peer with the smallest tag is next. A new waiter starts at
// the tag of the last served peer, so that neither idle time nor a new connection gains an advantage.
class BuildTurns {
 public:
  using Peer = const PeerBudget*;  // null: work without a peer
  // Chooses the next peer; the first of equal tags wins. `waiting` is non-empty, without duplicates, and its
  // peers are alive.
  Peer next(std::span<const Peer> waiting);
  void add_ns(Peer peer, int64_t ns) { tags_[peer] += ns; }

 private:
  std::map<Peer, int64_t> tags_;  // of the peers in the last call
  int64_t now_ = 0;
};

}  // namespace fire3dv::app
