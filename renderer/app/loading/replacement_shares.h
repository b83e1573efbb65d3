// Shares of peers in the time that replaced scenes take on the render thread. A peer whose changes made the
// scene be replaced rests before its next ones are built, so that it takes a quarter of that thread at most
// while others are active, and half of it alone. Others do not wait for its rest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "protocol/base/peer_budget.h"

namespace fire3dv::app {

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

 private:
  struct Entry {
    std::weak_ptr<PeerBudget> peer;
    int64_t earliest_ns = 0;
  };
  std::map<const PeerBudget*, Entry> entries_;
  int64_t newcomers_ns_ = 0;
};

}  // namespace fire3dv::app
