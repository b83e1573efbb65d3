// Decisions of a generated test: first the bytes of the fuzzer's input, then numbers of a generator that is
// seeded by the whole input. Equal inputs give equal decisions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <random>
#include <span>

namespace fire3dv::fuzz {

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

}  // namespace fire3dv::fuzz
