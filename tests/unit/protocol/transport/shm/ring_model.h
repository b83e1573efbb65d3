// Exhaustive model of the broadcast ring in the C++20 memory model, with one writer that reads nothing and
// readers that write nothing. It runs the real steps (shm_ring.h). docs/design/ring-model.md explains
// why the search is complete.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "protocol/transport/shm/shm_ring.h"

namespace fire3dv::transport::test {

// Number of known stores of each location, at least.
using View = std::vector<uint32_t>;

inline void join(View& view, const View& other) {
  for (size_t place = 0; place < view.size(); ++place) view[place] = std::max(view[place], other[place]);
}

struct Shape {
  uint64_t slots;
  uint64_t payload_words;  // of a slot

  size_t words_of_slot() const { return 3 + payload_words; }
  size_t places() const { return slots * words_of_slot() + 1; }
  size_t place(uint64_t number, shm::RingWord word) const {
    if (word == shm::RingWord::published) return places() - 1;
    return (number - 1) % slots * words_of_slot() + static_cast<size_t>(word);
  }
  size_t payload_place(uint64_t number, uint64_t word) const {
    return (number - 1) % slots * words_of_slot() + 3 + word;
  }
};

// Contents of message `number`. Messages differ in length, and each word identifies its message.
inline uint64_t bytes_of_message(const Shape& shape, uint64_t number) {
  return 8 * (1 + number % shape.payload_words);
}
inline uint64_t tag_of_message(uint64_t number) {
  return 1000 + number;
}
inline uint64_t word_of_message(uint64_t number, uint64_t word) {
  return 100 * number + word;
}

// A mutation: a step of a write or a read, counted from its first, is left out or loses its memory order.
struct Fault {
  enum class Kind { none, leave_out, relax };
  Kind kind = Kind::none;
  int step = -1;

  bool leaves_out(int at) const { return kind == Kind::leave_out && step == at; }
  std::memory_order order_of(int at, std::memory_order order) const {
    return kind == Kind::relax && step == at ? std::memory_order_relaxed : order;
  }
};

struct Store {
  size_t place;
  uint64_t value;
  View carries;
};

// All stores of the writer, in their order.
class WrittenRing {
 public:
  WrittenRing(Shape shape, uint64_t messages, Fault fault) : shape_(shape), fault_(fault) {
    now_.assign(shape.places(), 0);
    at_fence_ = now_;
    for (number_ = 1; number_ <= messages; ++number_) {
      step_ = 0;
      shm::write_steps(*this, number_, bytes_of_message(shape, number_), tag_of_message(number_));
      steps_ = step_;
    }
  }

  const std::vector<Store>& stores() const { return stores_; }
  int steps_of_a_write() const { return steps_; }

  // --- memory interface of write_steps()
  void store(shm::RingWord word, uint64_t value, std::memory_order order) {
    const int step = step_++;
    if (fault_.leaves_out(step)) return;
    append(shape_.place(number_, word), value, fault_.order_of(step, order));
  }
  void copy_in() {
    if (fault_.leaves_out(step_++)) return;
    for (uint64_t word = 0; 8 * word < bytes_of_message(shape_, number_); ++word)
      append(shape_.payload_place(number_, word), word_of_message(number_, word), std::memory_order_relaxed);
  }
  void fence(std::memory_order) {
    if (fault_.leaves_out(step_++)) return;
    at_fence_ = now_;
  }

 private:
  void append(size_t place, uint64_t value, std::memory_order order) {
    ++now_[place];
    View carries = order == std::memory_order_release ? now_ : at_fence_;
    carries[place] = std::max(carries[place], now_[place]);
    stores_.push_back({place, value, std::move(carries)});
  }

  Shape shape_;
  Fault fault_;
  View now_, at_fence_;
  uint64_t number_ = 0;
  int step_ = 0;
  int steps_ = 0;
  std::vector<Store> stores_;
};

// Reader's knowledge between two calls: `later` becomes known at an acquire fence.
struct Knowledge {
  View sure, later;
  auto operator<=>(const Knowledge&) const = default;
};

// One call of a reader in one of its executions: each load returns one of the visible stores.
class ModelReader {
 public:
  // `done`: number of stores that the writer has completed.
  ModelReader(const Shape& shape, const WrittenRing& ring, size_t done, Fault fault)
      : shape_(shape), fault_(fault), of_place_(shape.places()) {
    for (size_t i = 0; i < done; ++i) of_place_[ring.stores()[i].place].push_back(&ring.stores()[i]);
  }

  // Runs `call` once for each execution; `call` uses this reader as its memory.
  template <typename Call>
  void all_ways(const Knowledge& before, uint64_t number, Call&& call) {
    choices_.clear();
    do {
      knows = before;
      number_ = number;
      at_ = 0;
      step_ = 0;
      call();
    } while (next_way());
  }
  // The execution in which every load returns the newest store.
  template <typename Call>
  void newest_way(const Knowledge& before, uint64_t number, Call&& call) {
    newest_ = true;
    all_ways(before, number, call);
    newest_ = false;
  }

  Knowledge knows;
  std::vector<uint64_t> copied;
  uint64_t seen_sequence = 0;  // by the last load
  int steps() const { return step_; }

  // --- memory interface of published_step() and read_steps()
  uint64_t load(shm::RingWord word, std::memory_order order) {
    const int step = step_++;
    if (fault_.leaves_out(step)) return 2 * number_;  // the expected sequence, without a load
    const uint64_t value = load_place(shape_.place(number_, word), fault_.order_of(step, order));
    if (word == shm::RingWord::sequence) seen_sequence = value;
    return value;
  }
  void copy_out(uint64_t bytes) {
    copied.clear();
    if (fault_.leaves_out(step_++)) return;
    for (uint64_t word = 0; 8 * word < bytes; ++word)
      copied.push_back(load_place(shape_.payload_place(number_, word), std::memory_order_relaxed));
  }
  void fence(std::memory_order) {
    if (fault_.leaves_out(step_++)) return;
    join(knows.sure, knows.later);
  }

 private:
  struct Choice {
    uint32_t taken, last;
  };

  uint64_t load_place(size_t place, std::memory_order order) {
    const auto& stores = of_place_[place];
    const uint32_t oldest = knows.sure[place], newest = static_cast<uint32_t>(stores.size());
    if (at_ == choices_.size()) choices_.push_back({newest_ ? newest : oldest, newest});
    const uint32_t seen = choices_[at_++].taken;
    knows.sure[place] = seen;
    if (seen == 0) return 0;  // a new segment is zeroed
    join(order == std::memory_order_acquire ? knows.sure : knows.later, stores[seen - 1]->carries);
    return stores[seen - 1]->value;
  }

  bool next_way() {
    while (!choices_.empty() && choices_.back().taken == choices_.back().last) choices_.pop_back();
    if (choices_.empty()) return false;
    ++choices_.back().taken;
    return true;
  }

  Shape shape_;
  Fault fault_;
  std::vector<std::vector<const Store*>> of_place_;
  std::vector<Choice> choices_;
  size_t at_ = 0;
  uint64_t number_ = 0;
  int step_ = 0;
  bool newest_ = false;
};

}  // namespace fire3dv::transport::test
