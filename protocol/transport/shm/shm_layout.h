// Memory layout of a shared-memory segment, as defined in protocol/SPEC-transport.md. Both sides compile this
// header. Every field that is written concurrently is an atomic 32- or 64-bit word.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace fire3dv::transport::shm {

static_assert(std::endian::native == std::endian::little, "the segment is drawn for little-endian machines");
static_assert(std::atomic_ref<uint64_t>::is_always_lock_free, "a lock would die with its owner");

constexpr uint64_t kMagic = 0x314d485356443346;  // "F3DVSHM1"
constexpr uint32_t kLayoutVersion = 1;
constexpr uint32_t kHeaderBytes = 4096;
constexpr uint32_t kReaderCount = 16;
constexpr size_t kSlotHeaderBytes = 64;
constexpr uint64_t kMaxImageSlots = 8192;

// Broadcast ring: `count` slots of `stride` bytes.
struct RingGeometry {
  uint64_t offset;    // of the first slot, from the start of the segment
  uint64_t stride;    // multiple of 64
  uint64_t capacity;  // largest message in bytes, at most stride - kSlotHeaderBytes
  uint64_t count;     // power of two
};

// Keyed states: two consecutive halves. half_bytes 0: segment of a version without keyed states.
struct StatesGeometry {
  uint64_t offset;
  uint64_t half_bytes;  // multiple of 64
};

enum RingIndex : size_t { kPoseRing = 0, kDescriptionRing = 1, kControlRing = 2, kRingCount = 3 };

enum class SegmentState : uint64_t { live = 0, retired = 1, closed = 2 };

// Concurrently written word on its own cache line.
struct alignas(64) Word {
  uint64_t value;
};

// Generation g of the states is in half g mod 2.
struct StatesWords {
  Word generation;    // current generation; 0: none yet
  Word begun[2];      // per half: generation whose bytes are present or being written
  Word committed[2];  // per half: number of complete bytes
};

struct SegmentHeader {
  uint64_t magic;
  uint32_t layout_version;
  uint32_t header_bytes;
  uint64_t segment_bytes;
  uint64_t publisher_id;   // identical in all successive segments of one publisher
  uint32_t publisher_pid;  // informational; liveness is the lock on byte 0 of the file
  uint32_t reader_count;
  uint64_t readers_offset;
  uint64_t reader_stride;
  uint64_t carried_poses;  // 1: the first pose is the last one of the previous segment
  RingGeometry rings[kRingCount];
  StatesGeometry states;
  RingGeometry images;  // slots, not a ring; count 0: none
  // Poses published in earlier segments, without the carried one. A reader that missed a segment thus detects
  // whether it saw that pose.
  uint64_t poses_before;
  std::byte unused[40];
  // Concurrently written words from here on.
  Word published[kRingCount];  // number of the newest message of each ring; the first message is 1
  Word state;                  // SegmentState
  StatesWords states_words;
};
static_assert(offsetof(SegmentHeader, rings) == 64);
static_assert(offsetof(SegmentHeader, published) == 256);
static_assert(offsetof(SegmentHeader, state) == 448);
static_assert(offsetof(SegmentHeader, states) == 160);
static_assert(offsetof(SegmentHeader, images) == 176);
static_assert(offsetof(SegmentHeader, poses_before) == 208);
static_assert(offsetof(SegmentHeader, states_words) == 512);
static_assert(sizeof(SegmentHeader) == 832);

// Header of a ring slot, followed by the message at kSlotHeaderBytes.
struct SlotHeader {
  uint64_t sequence;  // 2n-1 while message n is being written, 2n when complete, 0 if never written
  uint64_t bytes;
  uint64_t tag;  // pose ring: number of the description in force
};

// Header of an image slot, followed by the block at kSlotHeaderBytes.
struct ImageSlotHeader {
  uint64_t owner;
  uint64_t bytes;
};

// Back channel of one reader: a single-producer single-consumer ring of 64-bit words.
constexpr uint64_t kReplyWords = 8192;
constexpr uint64_t kReplyMark =
    0x46334456;  // upper half of a message's first word; the lower half is its length
// The lower half is an image slot; the ticket follows in a second word.
constexpr uint64_t kImageMark = 0x46334457;
struct ReaderSlot {
  uint64_t active;            // 1 while the reader is attached; remains set if it dies, so the lock decides
  uint64_t pid;               // informational
  alignas(64) uint64_t head;  // words produced, written by the reader
  alignas(64) uint64_t tail;  // words consumed, written by the publisher
  alignas(64) uint64_t words[kReplyWords];
};
static_assert(offsetof(ReaderSlot, head) == 64 && offsetof(ReaderSlot, tail) == 128);
static_assert(offsetof(ReaderSlot, words) == 192);
static_assert(sizeof(ReaderSlot) == 192 + kReplyWords * 8);

// Liveness locks on bytes of the segment's file: the kernel releases them when their owner dies.
constexpr int64_t kPublisherLockByte = 0;
// Held briefly while taking over the name of a dead publisher. Distinct from byte 0, which would look alive
// to a reader.
constexpr int64_t kTakeOverLockByte = 64;
constexpr int64_t reader_lock_byte(uint32_t reader) {
  return 1 + static_cast<int64_t>(reader);
}

inline std::atomic_ref<uint64_t> atomic_word(uint64_t& word) {
  return std::atomic_ref<uint64_t>(word);
}

}  // namespace fire3dv::transport::shm
