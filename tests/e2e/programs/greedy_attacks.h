// Attacks of one connected peer on what other peers share with it: the render thread, the build thread,
// memory and nodes. Every message is valid; its number, its size or its target does the harm.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace fire3dv::test {

struct Target {
  std::string tcp_uri, udp_uri;
  uint64_t epoch = 0;              // of the honest peer's stream
  std::vector<std::string> nodes;  // that the honest peer drives
  std::string asset;               // file of a binary glTF
};

using Attack = std::function<void(const Target&)>;  // returns when stop_requested(), or throws PeerClosed
const std::map<std::string, Attack>& greedy_attacks();

}  // namespace fire3dv::test
