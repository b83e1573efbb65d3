// UDP session of a peer that builds its bundles of scene edits itself (protocol/transport/udp/udp_control.h).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace fire3dv::test {

// Opens a session without a key, sends one bundle and waits until all of it is acknowledged. Throws
// PeerClosed (raw_peer.h) if the renderer does not answer or ends the session, or if the test wants to stop.
void send_bundle(const std::string& uri, const std::vector<std::byte>& bundle);

}  // namespace fire3dv::test
