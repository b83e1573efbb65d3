// Metrics of peer budgets: use, limits and refusals by peer and resource. The number of listed peers is
// bounded.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "protocol/base/peer_limits.h"
#include "renderer/metrics/exposition.h"

namespace fire3dv::metrics {

// Peers with the least use beyond this number are counted, not listed.
constexpr size_t kMaxListedPeers = 64;

struct PeerUse {
  std::string peer;    // name; made unique and printable by write_peer_use()
  std::string stream;  // stream number as in other families; empty: none
  std::array<uint64_t, kResourceCount> used{}, refused{};
};

void write_peer_use(Exposition& page, const PeerLimits& limits, std::vector<PeerUse> peers);

}  // namespace fire3dv::metrics
