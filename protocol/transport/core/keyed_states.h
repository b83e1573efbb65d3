// Keyed states: control messages with a key, of which only the newest value counts. KeyedStates is the
// publisher's store; StateBatches is the send queue of one connection.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <unordered_map>
#include <utility>

#include "protocol/transport/link.h"

namespace fire3dv::transport {

struct KeyedState {
  uint64_t number = 0;  // ordinal of put(), from 1
  SharedBytes message;
  uint64_t hash = 0;  // UDP only
};

class KeyedStates {
 public:
  void put(uint64_t key, SharedBytes message, uint64_t hash = 0) {
    const auto [known, is_new] = number_of_key_.try_emplace(key, newest_ + 1);
    if (!is_new) {
      const auto replaced = by_number_.find(known->second);
      bytes_ -= replaced->second.message->size();
      by_number_.erase(replaced);
      known->second = newest_ + 1;
    }
    ++newest_;
    bytes_ += message->size();
    by_number_.emplace_hint(by_number_.end(), newest_, KeyedState{newest_, std::move(message), hash});
  }

  // Empty store that continues the numbering, so that new states are newer than all old ones.
  KeyedStates cleared() const {
    KeyedStates result;
    result.newest_ = newest_;
    return result;
  }

  uint64_t newest() const { return newest_; }
  size_t bytes() const { return bytes_; }
  size_t count() const { return by_number_.size(); }

  // Sorted by age, oldest first.
  const std::map<uint64_t, KeyedState>& in_order() const { return by_number_; }

 private:
  std::unordered_map<uint64_t, uint64_t> number_of_key_;
  std::map<uint64_t, KeyedState> by_number_;
  uint64_t newest_ = 0;
  size_t bytes_ = 0;
};

// Send queue of one connection, in batches. States put during a batch wait for the next one, where newer
// values replace them. Every batch therefore ends, and memory is bounded by two values per key.
class StateBatches {
 public:
  // Marks all states as unsent.
  void start_connection() {
    batch_.clear();
    batched_up_to_ = 0;
  }
  // Drops unsent states of an earlier description.
  void discard(const KeyedStates& states) {
    batch_.clear();
    batched_up_to_ = states.newest();
  }

  bool in_batch() const { return !batch_.empty(); }
  // True if a batch is open or a newer state exists. The newest state is always stored, unless the store is
  // empty.
  bool has_unsent(const KeyedStates& states) const {
    return in_batch() || (states.count() != 0 && batched_up_to_ < states.newest());
  }

  // Next message, or null. Starts the next batch when the current one is complete.
  const KeyedState* next(const KeyedStates& states) {
    if (batch_.empty() && batched_up_to_ < states.newest()) {
      const auto& all = states.in_order();
      for (auto state = all.upper_bound(batched_up_to_); state != all.end(); ++state)
        batch_.push_back(state->second);
      batched_up_to_ = states.newest();
    }
    return batch_.empty() ? nullptr : &batch_.front();
  }
  void pop() { batch_.pop_front(); }

 private:
  std::deque<KeyedState> batch_;
  uint64_t batched_up_to_ = 0;
};

}  // namespace fire3dv::transport
