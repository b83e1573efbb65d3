// Segments as files in /dev/shm: made, named, found, checked, mapped and locked.
#pragma once

#include <memory>
#include <string>

#include "protocol/error.h"
#include "protocol/transport/fork_guard.h"
#include "protocol/transport/shm_layout.h"
#include "protocol/transport/unique_fd.h"

namespace fire3dv::transport::shm {

// A file mapped for reading and writing as a whole.
class Mapping {
 public:
  // Throws nothing; an empty mapping means that the system refused (errno says why).
  static Mapping of(int fd, size_t bytes, bool touch_all_pages);

  std::byte* base() const { return base_; }
  explicit operator bool() const { return base_ != nullptr; }

 private:
  std::shared_ptr<void> region_;
  std::byte* base_ = nullptr;
};

struct Segment {
  UniqueFd fd;
  // An open file description of its own, which the mapping does not share: it holds the locks, and they go
  // with it.
  UnforkableFd lock_fd;
  Mapping mapping;
  SegmentHeader geometry{};  // a private copy that was checked; the mapped one is never believed for sizes

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
  uint64_t state_bytes;  // of each half
  uint64_t image_bytes = 0;
  uint64_t image_slots = 0;
};

// A segment without a name, with the publisher's lock held and memory set aside for all of it.
Result<Segment> create_segment(const std::string& name, const SegmentSizes& sizes, uint64_t publisher_id);

// Gives the segment its name. Takes the name from a dead publisher's segment, or with `replace_own` from the
// caller's own earlier one; a live publisher's is an error that names its process.
Result<void> take_name(const Segment& segment, const std::string& name, bool replace_own);

// Removes the name if it still names this segment.
void drop_name(const Segment& segment, const std::string& name);

struct FileId {
  uint64_t device = 0;
  uint64_t inode = 0;
  bool operator==(const FileId&) const = default;
};
FileId file_id(int fd);
FileId file_id(const std::string& path);  // zeros when there is none

// Opens what bears the name now, for a reader. found.fd is empty when nothing does or its publisher is dead.
// An error is something that a person should read: a file that is no segment, of another version, or not safe
// to open.
struct Found {
  Segment segment;
  FileId id;
};
Result<Found> find_segment(const std::string& name, FileId& seen);

// The same file once more, as an open file description of its own.
UnforkableFd open_again(int fd);

// Locks on one byte of a segment's file. `held_by_other` looks without taking.
bool try_lock_byte(int fd, int64_t byte);
void unlock_byte(int fd, int64_t byte);
bool byte_held_by_other(int fd, int64_t byte);

}  // namespace fire3dv::transport::shm
