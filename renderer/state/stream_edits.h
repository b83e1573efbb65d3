// Scene edits of one stream on their way to the scene: the newest of each key, until take(). Keys and values
// are charged to the peer's budget. The applied version decides which pose frames may be shown. Not
// thread-safe.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/peer_budget.h"
#include "protocol/wire/scene_edit.h"

namespace fire3dv::state {

class StreamEdits {
 public:
  enum class Outcome {
    accepted,
    stale,    // not newer than the received ones
    refused,  // over the budget. Its version counts as received: frames must not wait for it forever
  };

  StreamEdits() = default;
  // budget null: no limits.
  explicit StreamEdits(std::shared_ptr<PeerBudget> budget);

  Outcome add(wire::SceneEdit&& edit);
  // An edit of a later minor version: without effect, but applied.
  Outcome skip(uint64_t version);

  // Limit and message of the last refused edit.
  Resource refused_resource() const { return refused_resource_; }
  const std::string& refusal() const { return refusal_; }

  // All edits up to this version are in effect, or will be before the next image.
  uint64_t applied() const {
    return loading_.empty() ? received_ : std::min(received_, *loading_.begin() - 1);
  }

  // Edits by version, without those that a newer one of their key replaced.
  struct Batch {
    std::vector<wire::SceneEdit> edits;
    std::vector<BudgetCharge> charges;  // one per edit; held while its value is in force
  };
  // Returns and clears the edits since the last call.
  Batch take();
  bool has_new() const { return !pending_.empty(); }
  // True if take() has returned an edit.
  bool has_applied() const { return has_applied_; }

  // From now on added nodes and vertices load on another thread: they are in effect after finish() of their
  // version.
  void load_assets_asynchronously() { loads_asynchronously_ = true; }
  void finish(uint64_t version) { loading_.erase(version); }

 private:
  using Key = std::pair<std::string, wire::Property>;
  struct Pending {
    wire::SceneEdit edit;
    BudgetCharge charge;
  };
  Outcome refuse(Resource resource, std::string message);
  Result<void> charge_key(const Key& key);
  void drop_key(const Key& key);

  std::shared_ptr<PeerBudget> budget_;
  std::set<Key> keys_;  // pending or in force
  BudgetCharge key_count_, key_bytes_;
  std::map<Key, Pending> pending_;
  uint64_t received_ = 0;
  bool loads_asynchronously_ = false;
  std::set<uint64_t> loading_;
  bool has_applied_ = false;
  Resource refused_resource_ = Resource::edits;
  std::string refusal_;
};

}  // namespace fire3dv::state
