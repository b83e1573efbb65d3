// Fuzz target of shared-memory segments with overwritten words: a reader, and a publisher that reads replies,
// accept valid data or report damage, and access no memory outside of the segment.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "base/error.h"
#include "protocol/transport/core/byte_order.h"
#include "protocol/transport/shm/shm_reader.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {
namespace {

using namespace transport;
using namespace transport::shm;

constexpr uint64_t kImageBytes = 2048, kImageSlots = 4;

struct Victim {
  std::string name = "fuzz-" + std::to_string(::getpid());
  Segment segment;

  Victim() {
    auto made = create_segment(name, {4000, 4, 2000, 4096, kImageBytes, kImageSlots}, 99);
    FIRE3DV_ASSERT(made.ok());
    segment = std::move(*made);
    SegmentHeader& header = segment.header();
    const std::vector<std::byte> message(1000, std::byte{1});
    for (size_t i = 0; i < kRingCount; ++i) {
      RingWriter ring(segment.mapping.base(), segment.geometry.rings[i], header.published[i].value);
      for (int n = 0; n < 5; ++n) ring.write({message, {}}, 1);
    }
    KeyedStates states;
    StatesWriter writer(segment.mapping.base(), segment.geometry.states, header.states_words);
    for (uint64_t key = 0; key < 3; ++key) {
      states.put(key, std::make_shared<const wire::Bytes>(100 * key));
      writer.put(states, 1);
    }
    ReplyProducer(segment.reader(0)).push(message);
    FIRE3DV_ASSERT(take_name(segment, name, false).ok());
  }
  ~Victim() { drop_name(segment, name); }
};

constexpr size_t kWordBytes = 12;

void append(Input& input, uint32_t offset, uint64_t value) {
  for (int i = 0; i < 4; ++i) input.push_back(static_cast<uint8_t>(offset >> (8 * i)));
  for (int i = 0; i < 8; ++i) input.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

}  // namespace

// An input is a list of words: offset (u32) and new value (u64).
std::vector<Input> seeds() {
  std::vector<Input> inputs(9);
  append(inputs[0], 256, 6);          // number of published poses
  append(inputs[1], 64, 4096);        // offset of the pose ring
  append(inputs[1], 64 + 16, 100);    // and its capacity
  append(inputs[2], 4096 + 64, 500);  // head of a reply ring
  append(inputs[2], 4096 + 192, 0x4633445600000040);
  append(inputs[3], 448, 1);  // retired
  append(inputs[3], 320, 7);
  append(inputs[4], 512, 2);  // another generation of the state log
  append(inputs[4], 576, 2);
  append(inputs[4], 704, 48);
  append(inputs[5], 768, 4096);  // bytes in the state log
  append(inputs[6], 160, 4096);  // offset of the state log
  append(inputs[6], 168, 64);
  append(inputs[7], 176, 4096);  // offset of the images
  append(inputs[7], 184, 128);
  append(inputs[8], 192, 4096);  // their length and number
  append(inputs[8], 200, 8);
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  using namespace fire3dv::fuzz;
  static Victim victim;
  std::byte* const base = victim.segment.mapping.base();
  const size_t words = victim.segment.geometry.segment_bytes / 8;
  std::map<size_t, uint64_t> before;
  for (; size >= kWordBytes; data += kWordBytes, size -= kWordBytes) {
    const auto* bytes = reinterpret_cast<const std::byte*>(data);
    const size_t at = get_le<uint32_t>(bytes) / 8 % words * 8;
    uint64_t word;
    std::memcpy(&word, base + at, 8);
    before.emplace(at, word);
    word = get_le<uint64_t>(bytes + 4);
    std::memcpy(base + at, &word, 8);
  }
  for (const Delivery delivery : {Delivery::newest, Delivery::all}) {
    FileId seen;
    auto found = find_segment(victim.name, seen);
    if (!found || !found->segment.fd) continue;
    LinkCounters counters;
    Progress progress;
    Reader reader(std::move(*found), delivery, delivery == Delivery::all ? &progress : nullptr, counters);
    size_t messages = 0;
    (void)reader.drain(progress, [&](LinkEvent::Kind, std::span<const std::byte> message, uint64_t) {
      FIRE3DV_ASSERT(message.size() <= victim.segment.geometry.segment_bytes);
      FIRE3DV_ASSERT(++messages <= 4096);
    });
    for (uint64_t request = 1; request <= 3; ++request)
      (void)reader.send_image(request, std::vector<std::byte>(200), 500,
                              [](std::span<std::byte> pixels) { std::ranges::fill(pixels, std::byte{7}); });
    (void)reader.end_by_state();
    (void)reader.has_unread();
  }
  ReplyConsumer replies(victim.segment.reader(0));
  std::vector<std::byte> message;
  const RingGeometry& geometry = victim.segment.geometry.images;
  ImageReader images(base, geometry);
  for (int i = 0; i < 64; ++i) {
    ImageNotification notice;
    if (replies.pop(message, notice) != ReplyConsumer::Outcome::image || !images.is_sound(notice)) continue;
    const auto block = images.take(notice, 0);
    if (!block) continue;
    FIRE3DV_ASSERT(block->data() >= base && block->size() <= geometry.capacity);
    images.let_go(notice.slot);
  }
  images.free_unfinished([](uint32_t) { return false; }, [](const auto&, uint32_t) { return false; });
  for (uint64_t slot = 0; slot < geometry.count; ++slot)
    std::memset(base + geometry.offset + slot * geometry.stride, 0, kSlotHeaderBytes);
  for (const auto& [at, word] : before) std::memcpy(base + at, &word, 8);
  std::memset(&victim.segment.reader(1), 0, 192);  // clears the slot that the readers above left
  return 0;
}
