// Peer of a fuzzed session: generates mostly valid messages with boundary values from the fuzzer's input, and
// records what it has sent.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"
#include "tests/fuzz/choices.h"

namespace fire3dv::fuzz {

class SessionPeer {
 public:
  // A new connection: clears the peer's state.
  void reset() { *this = {}; }

  wire::Bytes describe(Choices& choices, const std::set<uint64_t>& epochs_of_others);
  wire::Bytes pose_frame(Choices& choices);
  wire::Bytes edit(Choices& choices);
  wire::Bytes image_request(Choices& choices);
  wire::Bytes goodbye(Choices& choices);
  // Pings, replies that only renderers send, and undecodable bytes.
  static wire::Bytes other_message(Choices& choices);

  bool is_connected = false;
  uint64_t epoch = 0;       // of its last description; 0: none, or after a goodbye
  bool is_damaged = false;  // a message was mutated in transit: the state recorded here may be wrong
  std::map<uint32_t, uint64_t> requests;  // well-formed requests of this epoch: ids by place

 private:
  wire::SceneEdit edit_of(Choices& choices, wire::Property property);

  std::vector<std::string> names_;
  uint64_t sequence_ = 0, version_ = 0;
};

}  // namespace fire3dv::fuzz
