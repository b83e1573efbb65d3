#include "renderer/capture/amodal.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

#include "renderer/passes/outputs/silhouettes.h"

namespace fire3dv::capture {
namespace {

uint32_t word_at(std::span<const uint8_t> bytes, size_t index) {
  uint32_t word = 0;
  std::memcpy(&word, bytes.data() + index * sizeof word, sizeof word);
  return word;
}

void add_pixel(wire::AmodalRecord& record, uint32_t x, uint32_t y) {
  const bool is_first = record.pixels++ == 0;
  record.min_x = is_first ? x : std::min(record.min_x, x);
  record.min_y = is_first ? y : std::min(record.min_y, y);
  record.max_x = std::max(record.max_x, x + 1);
  record.max_y = std::max(record.max_y, y + 1);
}

}  // namespace

sinks::Amodal read_silhouettes(std::span<const uint8_t> bits, std::span<const uint8_t> instance_plane,
                               uint32_t width, uint32_t height, std::span<const Silhouetted> slots) {
  const auto count = static_cast<uint32_t>(slots.size());
  const size_t pixels = size_t{width} * height, mask_row = (width + 7) / 8, mask_bytes = mask_row * height;
  const uint32_t words = passes::silhouette_words(count);
  FIRE3DV_ASSERT(bits.size() == passes::silhouette_bytes(count, width, height) &&
                 instance_plane.size() == pixels * sizeof(uint32_t));
  std::vector<wire::AmodalRecord> of_slot(count);
  std::vector<uint8_t> masks(mask_bytes * count);
  const auto shown_slot = [&](size_t pixel) {  // count: none
    const uint32_t instance = word_at(instance_plane, pixel);
    const auto at = std::lower_bound(slots.begin(), slots.end(), instance,
                                     [](const Silhouetted& slot, uint32_t id) { return slot.instance < id; });
    return at != slots.end() && at->instance == instance ? static_cast<uint32_t>(at - slots.begin()) : count;
  };
  for (size_t pixel = 0; pixel < pixels; ++pixel) {
    const auto x = static_cast<uint32_t>(pixel % width), y = static_cast<uint32_t>(pixel / width);
    const uint32_t shown = shown_slot(pixel);
    if (shown < count) ++of_slot[shown].visible_pixels;
    for (uint32_t word = 0; word < words; ++word) {
      uint32_t left = word_at(bits, word * pixels + pixel);
      if (shown / 32 == word && shown < count) left |= 1u << (shown % 32);
      for (; left != 0; left &= left - 1) {
        const uint32_t slot = 32 * word + static_cast<uint32_t>(std::countr_zero(left));
        if (slot >= count) break;
        add_pixel(of_slot[slot], x, y);
        masks[slot * mask_bytes + y * mask_row + x / 8] |= static_cast<uint8_t>(0x80u >> (x % 8));
      }
    }
  }
  sinks::Amodal amodal;
  for (uint32_t slot = 0; slot < count; ++slot) {
    wire::AmodalRecord& record = of_slot[slot];
    if (record.pixels == 0) continue;
    record.instance = slots[slot].instance;
    record.semantic = slots[slot].semantic;
    record.is_truncated = word_at(bits, words * pixels + slot / 32) >> (slot % 32) & 1;
    amodal.records.push_back(record);
    const auto mask = masks.begin() + static_cast<std::ptrdiff_t>(slot * mask_bytes);
    amodal.masks.insert(amodal.masks.end(), mask, mask + static_cast<std::ptrdiff_t>(mask_bytes));
  }
  return amodal;
}

}  // namespace fire3dv::capture
