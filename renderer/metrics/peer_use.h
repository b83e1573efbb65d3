// Metrics of peers' budgets: use, limits and refusals by peer and resource, for a bounded number of peers.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "protocol/base/peer_limits.h"
#include "renderer/metrics/exposition.h"

namespace fire3dv::metrics {

// Peers beyond this number, those with the least use, are counted but not listed.
constexpr size_t kMaxListedPeers = 64;

struct PeerUse {
  std::string peer;    // name; made unique and printable by write_peer_use()
  std::string stream;  // number of the peer's stream, as in other families; empty: it has none
  std::array<uint64_t, kResourceCount> used{}, refused{};
};

void write_peer_use(Exposition& page, const PeerLimits& limits, std::vector<PeerUse> peers);

}  // namespace fire3dv::metrics
