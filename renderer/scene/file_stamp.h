// Which file it is and when it was written last: cheaper to ask for than what it holds.
#pragma once

#include <cstdint>
#include <filesystem>

#include "renderer/scene/digest.h"

namespace fire3dv::scene {

struct FileStamp {
  bool exists = false;
  uint64_t size = 0, inode = 0;
  int64_t modified_ns = 0, changed_ns = 0;  // as the file system's clock had it
  bool operator==(const FileStamp&) const = default;

  // File systems stamp with a clock that ticks. What was written so shortly before the time may be
  // written again without another stamp.
  bool is_settled_at(int64_t time_ns) const;
};

FileStamp stamp_of(const std::filesystem::path& file);

// What a file held when it had this stamp.
struct StampedDigest {
  Digest digest{};
  FileStamp stamp;
  int64_t taken_ns = 0;  // by the system's clock, before the stamp was taken, which was before the digest
  // True only if what was read of the file between taken_ns and now is what the digest is of. Some file
  // systems' clocks tick every two seconds, and that of a network's server may be ahead of ours.
  bool holds(const std::filesystem::path& file) const {
    constexpr int64_t kSlowestTick_ns = 5'000'000'000;
    return stamp.exists && stamp_of(file) == stamp && stamp.is_settled_at(taken_ns - kSlowestTick_ns);
  }
};

// Regular files only. The error is digest_of_file's.
Result<StampedDigest> stamped_digest_of(const std::filesystem::path& file, uint64_t max_bytes);

}  // namespace fire3dv::scene
