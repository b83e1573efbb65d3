#include "protocol/transport/udp/udp_peers.h"

#include <algorithm>
#include <utility>

namespace fire3dv::transport::udp {

Peer& PeerTable::add(uint64_t session, Peer&& newcomer) {
  Peer& peer = peers_.emplace(session, std::move(newcomer)).first->second;
  session_at_[peer.address] = session;
  return peer;
}

void PeerTable::remove(uint64_t session) {
  const auto found = peers_.find(session);
  if (found == peers_.end()) return;
  if (const auto at = session_at_.find(found->second.address);
      at != session_at_.end() && at->second == session)
    session_at_.erase(at);
  peers_.erase(found);
}

Peer* PeerTable::find(uint64_t session) {
  const auto found = peers_.find(session);
  return found != peers_.end() ? &found->second : nullptr;
}

uint64_t PeerTable::session_at(const Address& address) const {
  const auto found = session_at_.find(address);
  return found != session_at_.end() ? found->second : 0;
}

uint64_t PeerTable::session_of(PeerId peer) const {
  const auto found =
      std::find_if(peers_.begin(), peers_.end(), [&](const auto& entry) { return entry.second.id == peer; });
  return found != peers_.end() ? found->first : 0;
}

}  // namespace fire3dv::transport::udp
