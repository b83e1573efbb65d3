#include "renderer/scene/textures/ktx2/etc1s_slice.h"

#include <utility>

namespace fire3dv::scene::ktx2 {
namespace {

// Variable-length number: groups of `bits` bits, each with a bit that announces another one. Groups beyond 32
// bits are ignored.
uint32_t read_number(BitReader& reader, uint32_t bits) {
  uint32_t value = 0;
  for (uint32_t shift = 0; shift < 32; shift += bits) {
    const uint32_t group = reader.bits(bits + 1);
    value |= (group & ((1u << bits) - 1)) << shift;
    if ((group >> bits) == 0) break;
  }
  return value;
}

// Approximate move-to-front list of recent selectors.
class History {
 public:
  explicit History(uint32_t size) : values_(size), next_(size / 2) {}

  size_t size() const { return values_.size(); }
  void add(uint32_t value) {
    if (values_.empty()) return;
    values_[next_++] = value;
    if (next_ == values_.size()) next_ = values_.size() / 2;
  }
  // Returns a value and moves it towards the front.
  uint32_t use(uint32_t index) {
    const uint32_t value = values_[index];
    std::swap(values_[index], values_[index / 2]);
    return value;
  }

 private:
  std::vector<uint32_t> values_;
  size_t next_;
};

// How each block of 2 x 2 finds its endpoint: 2 bits a block, the upper left one in the lowest bits.
class Predictions {
 public:
  explicit Predictions(uint32_t columns) : lower_row_((size_t{columns} + 1) / 2) {}

  // False: damaged.
  bool advance(BitReader& reader, const HuffmanCode& code, uint32_t x, uint32_t y) {
    if (x % 2 != 0) return true;
    if (y % 2 != 0) {
      bits_ = lower_row_[x / 2];
      return true;
    }
    if (repeats_ > 0) {
      --repeats_;
      bits_ = newest_;
    } else {
      const std::optional<uint32_t> symbol = code.decode(reader);
      if (!symbol || *symbol > kRepeat) return false;
      if (*symbol == kRepeat) {
        repeats_ = uint64_t{read_number(reader, 4)} + kLeastRepeats - 1;
      } else {
        newest_ = *symbol;
      }
      bits_ = newest_;
    }
    lower_row_[x / 2] = static_cast<uint8_t>(bits_ >> 4);
    return true;
  }
  uint32_t take() {
    const uint32_t prediction = bits_ & 3;
    bits_ >>= 2;
    return prediction;
  }

 private:
  static constexpr uint32_t kRepeat = 256, kLeastRepeats = 3;
  std::vector<uint8_t> lower_row_;
  uint32_t bits_ = 0, newest_ = 0;
  uint64_t repeats_ = 0;
};

class SelectorReader {
 public:
  SelectorReader(const SliceCodes& codes, size_t selector_count)
      : codes_(codes), selector_count_(static_cast<uint32_t>(selector_count)), history_(codes.history_size) {}

  // Index of the next block's selector. nullopt: damaged.
  std::optional<uint32_t> next(BitReader& reader) {
    if (run_ > 0) {
      --run_;
      return from_history(0);
    }
    const std::optional<uint32_t> symbol = codes_.selector.decode(reader);
    if (!symbol) return std::nullopt;
    if (*symbol < selector_count_) {
      history_.add(*symbol);
      return symbol;
    }
    if (*symbol - selector_count_ < history_.size()) return from_history(*symbol - selector_count_);
    if (*symbol - selector_count_ > history_.size()) return std::nullopt;
    constexpr uint32_t kLeastRun = 3, kLongRun = 63;
    const std::optional<uint32_t> run = codes_.history_run.decode(reader);
    if (!run) return std::nullopt;
    run_ = uint64_t{*run == kLongRun ? read_number(reader, 7) : *run} + kLeastRun - 1;
    return from_history(0);
  }

 private:
  std::optional<uint32_t> from_history(uint32_t index) {
    if (index >= history_.size()) return std::nullopt;
    return history_.use(index);
  }

  const SliceCodes& codes_;
  const uint32_t selector_count_;
  History history_;
  uint64_t run_ = 0;
};

}  // namespace

std::optional<std::vector<Etc1sBlock>> decode_slice(std::span<const std::byte> bytes, const SliceCodes& codes,
                                                    std::span<const Etc1sEndpoint> endpoints,
                                                    std::span<const Etc1sSelector> selectors,
                                                    uint32_t columns, uint32_t rows) {
  BitReader reader(bytes);
  Predictions predictions(columns);
  SelectorReader selector_reader(codes, selectors.size());
  std::vector<uint32_t> above(columns), current(columns);  // endpoint indices of two rows of blocks
  uint32_t previous = 0;
  std::vector<Etc1sBlock> blocks;
  blocks.reserve(size_t{columns} * rows);
  for (uint32_t y = 0; y < rows; ++y) {
    for (uint32_t x = 0; x < columns; ++x) {
      if (!predictions.advance(reader, codes.prediction, x, y)) return std::nullopt;
      const uint32_t prediction = predictions.take();
      uint32_t endpoint = previous;
      if ((prediction == 0 && x == 0) || (prediction == 1 && y == 0) ||
          (prediction == 2 && (x == 0 || y == 0)))
        return std::nullopt;
      if (prediction == 1) endpoint = above[x];
      if (prediction == 2) endpoint = above[x - 1];
      if (prediction == 3) {
        const std::optional<uint32_t> delta = codes.endpoint_delta.decode(reader);
        if (!delta) return std::nullopt;
        endpoint = previous + *delta;
        if (endpoint >= endpoints.size()) endpoint -= static_cast<uint32_t>(endpoints.size());
      }
      current[x] = previous = endpoint;
      const std::optional<uint32_t> selector = selector_reader.next(reader);
      if (!selector || *selector >= selectors.size() || endpoint >= endpoints.size() || reader.is_past_end())
        return std::nullopt;
      blocks.push_back({endpoints[endpoint], selectors[*selector]});
    }
    std::swap(above, current);
  }
  return blocks;
}

}  // namespace fire3dv::scene::ktx2
