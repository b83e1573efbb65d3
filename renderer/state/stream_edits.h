// Scene edits of one stream on their way to the scene: of each key the newest, until they are taken. Charges
// keys and values in force to the peer's budget, and decides which pose frames may be shown: those whose
// scene version is applied.
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
    taken,
    stale,    // not newer than what has come
    refused,  // over the budget; its version counts, or frames would wait for ever for what cannot be had
  };

  StreamEdits() = default;
  // Null: without limits.
  explicit StreamEdits(std::shared_ptr<PeerBudget> budget);

  Outcome add(wire::SceneEdit&& edit);
  // An edit of a later minor version: without effect, but applied.
  Outcome skip(uint64_t version);

  // Limit and sentence of the last edit that was refused.
  Resource refused_resource() const { return refused_resource_; }
  const std::string& refusal() const { return refusal_; }

  // All edits up to here are in effect, or will be before the next picture.
  uint64_t applied() const {
    return loading_.empty() ? received_ : std::min(received_, *loading_.begin() - 1);
  }

  // Edits since the last call by version, without those that a newer one of their key replaced.
  struct Taken {
    std::vector<wire::SceneEdit> edits;
    std::vector<BudgetCharge> charges;  // of each edit: held for as long as its value is in force
  };
  Taken take();
  bool has_news() const { return !waiting_.empty(); }
  // Something of this stream has been taken.
  bool was_taken() const { return was_taken_; }

  // Added nodes and vertices are not in effect when they come, but when finish() is told so: reading a file
  // takes longer than a frame. From now on.
  void load_aside() { load_aside_ = true; }
  void finish(uint64_t version) { loading_.erase(version); }

 private:
  using Key = std::pair<std::string, wire::Property>;
  struct Waiting {
    wire::SceneEdit edit;
    BudgetCharge charge;
  };
  Outcome refuse(Resource resource, std::string message);
  Result<void> charge_key(const Key& key);
  void drop_key(const Key& key);

  std::shared_ptr<PeerBudget> budget_;
  std::set<Key> keys_;  // that wait or are in force
  BudgetCharge key_count_, key_bytes_;
  std::map<Key, Waiting> waiting_;
  uint64_t received_ = 0;
  bool load_aside_ = false;
  std::set<uint64_t> loading_;
  bool was_taken_ = false;
  Resource refused_resource_ = Resource::edits;
  std::string refusal_;
};

}  // namespace fire3dv::state
