// Peer of a fuzzed session: makes messages that are mostly valid, with values at the edges, and remembers
// what it has told the renderer.
#pragma once

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
  // A new connection: what the peer knew is gone.
  void reset() { *this = {}; }

  wire::Bytes describe(Choices& choices, const std::set<uint64_t>& epochs_of_others);
  wire::Bytes pose_frame(Choices& choices);
  wire::Bytes edit(Choices& choices);
  wire::Bytes image_request(Choices& choices);
  wire::Bytes goodbye(Choices& choices);
  // Pings, replies that only renderers send, and bytes that are no message.
  static wire::Bytes other_message(Choices& choices);

  bool is_connected = false;
  uint64_t epoch = 0;                     // of its last description; 0: none, or it said goodbye
  bool is_damaged = false;                // a message was changed on its way: what it says here may be wrong
  std::map<uint32_t, uint64_t> requests;  // ids by place, sent in this epoch, all well-formed

 private:
  wire::SceneEdit edit_of(Choices& choices, wire::Property property);

  std::vector<std::string> names_;
  uint64_t sequence_ = 0, version_ = 0;
};

}  // namespace fire3dv::fuzz
