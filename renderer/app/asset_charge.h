// Charges of a peer for the nodes and assets that it adds to the scene, and the order in which peers' assets
// are loaded.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "protocol/base/peer_budget.h"
#include "renderer/scene/load_gltf.h"
#include "renderer/scene/scene_file.h"

namespace fire3dv::app {

// Amounts that one use of an asset adds to the scene.
struct AssetSize {
  uint64_t host_bytes = 0;  // decoded, once however often it is used
  uint64_t gpu_bytes = 0;
  uint64_t nodes = 0;
  uint64_t path_bytes = 0;                 // of its nodes' paths, before those are prefixed
  uint64_t lights = 0, shadow_lights = 0;  // nodes with such a light
};
AssetSize measure(const scene::LoadedScene& asset);

// Held for as long as a node is in the scene.
struct NodeCharges {
  BudgetCharge nodes, lights, shadow_lights, gpu, paths;
  bool casts_shadows = true;  // false: the lights of its asset are beyond the limit of shadow-lights
};
// asset: null for an empty node.
Result<NodeCharges> charge_node(const std::shared_ptr<PeerBudget>& budget, const AssetSize* asset);
// path_bytes: of the node and its asset's nodes, prefixes included. Several copies are charged: a path is
// held by the old and the new scene, by their indices of names, and by the build.
Result<void> charge_paths(NodeCharges& charges, const std::shared_ptr<PeerBudget>& budget,
                          uint64_t path_bytes);

// Limits of an asset: tighter than those of the user's file, and no more than the peer may have. `charge`
// grows with what the loader reserves, and outlives the load.
scene::LoadLimits limits_of_asset(const std::shared_ptr<PeerBudget>& budget, BudgetCharge& charge);

// Start-time fair queueing: of the peers that wait, the one whose tag is smallest is served next. A peer that
// begins to wait starts at the tag of the peer that was served last, so that neither idle time nor a new
// connection earns a lead.
class BuildTurns {
 public:
  using Peer = const PeerBudget*;  // null: everything that belongs to no peer
  // waiting: not empty, each peer once; the first of equal tags wins. They must be alive.
  Peer next(std::span<const Peer> waiting);
  void add_ns(Peer peer, int64_t ns) { tags_[peer] += ns; }

 private:
  std::map<Peer, int64_t> tags_;  // of the peers that waited last
  int64_t now_ = 0;
};

}  // namespace fire3dv::app
