// Shared-memory segments as files in /dev/shm: creation, naming, lookup, validation, mapping and locking.
#pragma once

#include <memory>
#include <string>

#include "base/error.h"
#include "base/unique_fd.h"
#include "protocol/transport/core/fork_guard.h"
#include "protocol/transport/shm/shm_layout.h"

namespace fire3dv::transport::shm {

// Read-write mapping of a whole file.
class Mapping {
 public:
  // Does not throw; an empty mapping means failure (see errno).
  static Mapping of(int fd, size_t bytes, bool touch_all_pages);

  std::byte* base() const { return base_; }
  explicit operator bool() const { return base_ != nullptr; }

 private:
  std::shared_ptr<void> region_;
  std::byte* base_ = nullptr;
};

struct Segment {
  UniqueFd fd;
  // Separate open file description, independent of the mapping: it holds the locks and releases them.
  UnforkableFd lock_fd;
  Mapping mapping;
  SegmentHeader geometry{};  // validated private copy; sizes are never read from the mapping

  SegmentHeader& header() const { return *reinterpret_cast<SegmentHeader*>(mapping.base()); }
  ReaderSlot& reader(uint32_t index) const {
    return *reinterpret_cast<ReaderSlot*>(mapping.base() + geometry.readers_offset +
                                          index * geometry.reader_stride);
  }
  SegmentState state() const {
    return static_cast<SegmentState>(atomic_word(header().state.value).load(std::memory_order_acquire));
  }
  void set_state(SegmentState state) const {
    atomic_word(header().state.value).store(static_cast<uint64_t>(state), std::memory_order_release);
  }
};

// "/dev/shm/fire3dv.NAME"
std::string segment_path(const std::string& name);

struct SegmentSizes {
  uint64_t pose_bytes;
  uint64_t pose_slots;
  uint64_t description_bytes;
  uint64_t state_bytes;  // per half
  uint64_t image_bytes = 0;
  uint64_t image_slots = 0;
};

// Creates an unnamed segment, holding the publisher's lock, with all of its memory allocated.
Result<Segment> create_segment(const std::string& name, const SegmentSizes& sizes, uint64_t publisher_id);

// Names the segment. Takes the name from a dead publisher's segment, or with `replace_own` from the caller's
// earlier one. Fails for a live publisher and names its process.
Result<void> take_name(const Segment& segment, const std::string& name, bool replace_own);

// Removes the name if it still refers to this segment.
void drop_name(const Segment& segment, const std::string& name);

struct FileId {
  uint64_t device = 0;
  uint64_t inode = 0;
  bool operator==(const FileId&) const = default;
};
FileId file_id(int fd);
FileId file_id(const std::string& path);  // zeros if there is none

// Opens the segment of this name for a reader. found.fd is empty if none exists or its publisher is dead.
// Errors are for the user: not a segment, another version, or unsafe to open.
struct Found {
  Segment segment;
  FileId id;
};
Result<Found> find_segment(const std::string& name, FileId& seen);

// Reopens the same file as a separate open file description.
UnforkableFd open_again(int fd);

// Locks on one byte of a segment's file. byte_held_by_other() tests without locking.
bool try_lock_byte(int fd, int64_t byte);
void unlock_byte(int fd, int64_t byte);
bool byte_held_by_other(int fd, int64_t byte);

}  // namespace fire3dv::transport::shm
