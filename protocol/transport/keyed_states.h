// Control messages of which only the newest of each key counts, as a publisher keeps them, and as one
// connection sends them on: whoever joins gets them all, and whoever was slow gets what is newest by now.
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
  uint64_t number = 0;  // counts puts, from 1
  SharedBytes message;
  uint64_t hash = 0;  // udp alone
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

  // Numbers go on: what comes is newer than what was.
  KeyedStates emptied() const {
    KeyedStates result;
    result.newest_ = newest_;
    return result;
  }

  uint64_t newest() const { return newest_; }
  size_t bytes() const { return bytes_; }
  size_t count() const { return by_number_.size(); }

  // Oldest first.
  const std::map<uint64_t, KeyedState>& in_order() const { return by_number_; }

 private:
  std::unordered_map<uint64_t, uint64_t> number_of_key_;
  std::map<uint64_t, KeyedState> by_number_;
  uint64_t newest_ = 0;
  size_t bytes_ = 0;
};

// What a connection has yet to send of them. It takes batches: what is put meanwhile waits for the next one,
// and is replaced there. So each batch ends, however fast keys change, and memory is bounded by two values of
// each key.
class StateBatches {
 public:
  // All of them are new to this connection.
  void start_connection() {
    batch_.clear();
    begun_up_to_ = 0;
  }
  // What has not begun to be sent belongs to an earlier description.
  void forget(const KeyedStates& states) {
    batch_.clear();
    begun_up_to_ = states.newest();
  }

  bool in_batch() const { return !batch_.empty(); }
  // What was put last is always there, unless all are gone.
  bool has_news(const KeyedStates& states) const {
    return in_batch() || (states.count() != 0 && begun_up_to_ < states.newest());
  }

  // The next message in line, null when there is none. Begins the next batch when the last one is over.
  const KeyedState* next(const KeyedStates& states) {
    if (batch_.empty() && begun_up_to_ < states.newest()) {
      const auto& all = states.in_order();
      for (auto state = all.upper_bound(begun_up_to_); state != all.end(); ++state)
        batch_.push_back(state->second);
      begun_up_to_ = states.newest();
    }
    return batch_.empty() ? nullptr : &batch_.front();
  }
  void pop() { batch_.pop_front(); }

 private:
  std::deque<KeyedState> batch_;
  uint64_t begun_up_to_ = 0;
};

}  // namespace fire3dv::transport
