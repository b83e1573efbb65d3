// Peer of a fuzzed session: generates mostly valid messages with boundary values from the fuzzer's input, and
// records what it has sent.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"

namespace fire3dv::fuzz {

// Decisions of a generated test: first the bytes of the fuzzer's input, then numbers of a generator that is
// seeded by the whole input. Equal inputs give equal decisions.
class Choices {
 public:
  explicit Choices(std::span<const uint8_t> input) : input_(input) {
    uint64_t hash = 0xcbf29ce484222325;
    for (const uint8_t byte : input) hash = (hash ^ byte) * 0x100000001b3;
    generator_.seed(hash);
  }
  // Returns 0 to count - 1.
  uint64_t below(uint64_t count) {
    if (next_ == input_.size()) return generator_() % count;
    return input_[next_++] * ((count + 255) / 256) % count;
  }
  bool one_in(uint64_t count) { return below(count) == 0; }
  template <typename T>
  T one_of(std::initializer_list<T> values) {
    return *(values.begin() + static_cast<std::ptrdiff_t>(below(values.size())));
  }
  template <typename Container>
  auto& any_of(Container& container) {
    return *std::next(container.begin(), static_cast<std::ptrdiff_t>(below(container.size())));
  }
  uint64_t number() { return generator_(); }

 private:
  std::span<const uint8_t> input_;
  size_t next_ = 0;
  std::mt19937_64 generator_;
};

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
