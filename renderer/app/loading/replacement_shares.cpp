#include "renderer/app/loading/replacement_shares.h"

#include <algorithm>

namespace fire3dv::app {
namespace {

// Cost of a replaced scene for each peer that changed it and for each of its nodes, in ns of loads.
constexpr int64_t kWeightOfPeer = 1'000'000, kWeightOfNode = 10'000;

int64_t weight_of(const ReplacementShares::Cause& cause) {
  return cause.load_ns + kWeightOfPeer + kWeightOfNode * static_cast<int64_t>(cause.nodes);
}

}  // namespace

int64_t ReplacementShares::earliest_ns(const Peer& peer) const {
  const auto entry = entries_.find(peer.get());
  // An address may have been given to another peer.
  const bool is_known = entry != entries_.end() && entry->second.peer.lock() == peer;
  return is_known ? entry->second.earliest_ns : newcomers_ns_;
}

void ReplacementShares::add(const Replacement& replacement) {
  std::erase_if(entries_, [](const auto& entry) { return entry.first && entry.second.peer.expired(); });
  double weights = 0;
  for (const Cause& cause : replacement.causes) weights += static_cast<double>(weight_of(cause));
  for (const Cause& cause : replacement.causes) {
    const double share = static_cast<double>(weight_of(cause)) / weights;
    const auto part = [share](int64_t ns) { return static_cast<int64_t>(share * static_cast<double>(ns)); };
    const int64_t rest_ns = replacement.is_alone ? kRestAlone * part(replacement.shown_ns)
                                                 : kRestOfShown * part(replacement.shown_ns) +
                                                       part(replacement.merge_ns) + cause.load_ns;
    Entry& entry = entries_[cause.peer.get()];
    entry = {cause.peer, std::max(entry.earliest_ns, replacement.end_ns + rest_ns)};
  }
  newcomers_ns_ = std::max(newcomers_ns_, replacement.end_ns + replacement.shown_ns);
}

}  // namespace fire3dv::app
