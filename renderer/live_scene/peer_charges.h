// Cost of the scene changes of each peer: budget charges for added nodes and assets, scheduling of asset
// loads, and shares in the time of replaced scenes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "base/peer_budget.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::app {

// Resource use of one instance of an asset.
struct AssetSize {
  uint64_t host_bytes = 0;  // decoded asset, counted once for all of its instances
  uint64_t gpu_bytes = 0;
  uint64_t nodes = 0;
  uint64_t path_bytes = 0;                 // paths of its nodes, without prefixes
  uint64_t lights = 0, shadow_lights = 0;  // nodes with such a light
  uint64_t deformed_corners = 0;           // see clusters.h
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

// Shares of peers in the time that replaced scenes take on the render thread. A peer whose changes made the
// scene be replaced rests before its next ones are built, so that it takes a quarter of that thread at most
// while others are active, and half of it alone; the rest grows for a peer that changes the scene all the
// time. Others do not wait for its rest.
class ReplacementShares {
 public:
  using Peer = std::shared_ptr<PeerBudget>;  // null: streams without a budget, and those that have ended

  // When the peer's changes may be built next. A peer that caused no replacement yet waits as long as the
  // last one took: new connections earn no lead.
  int64_t earliest_ns(const Peer& peer) const;

  struct Cause {
    Peer peer;
    int64_t load_ns = 0;  // of its assets
    size_t nodes = 0;     // that it has in the scene
  };
  // A scene with the changes of these peers has been built and shown. merge_ns: on the build thread, without
  // loads; shown_ns: on the render thread. Both are shared by what each peer loaded and has in the scene.
  struct Replacement {
    std::vector<Cause> causes;
    int64_t merge_ns = 0, shown_ns = 0;
    int64_t end_ns = 0;
    bool is_alone = false;  // no other peer has a stream
  };
  void add(const Replacement& replacement);

  static constexpr int64_t kRestOfShown = 3, kRestAlone = 1;
  // Replacements one after the other, without a second of calm, rest longer: twice as long after so many, up
  // to kMaxGrowth times, and kMaxGrownNs.
  static constexpr int64_t kStreak = 16, kMaxGrowth = 8, kCalmNs = 1'000'000'000, kMaxGrownNs = 1'000'000'000;

 private:
  struct Entry {
    std::weak_ptr<PeerBudget> peer;
    int64_t earliest_ns = 0;
    int64_t streak = 0;  // replacements without calm
  };
  std::map<const PeerBudget*, Entry> entries_;
  int64_t newcomers_ns_ = 0;
};

}  // namespace fire3dv::app
