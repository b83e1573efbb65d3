// File stamp: identity, size and times of a file. It detects changes without reading the contents. With the
// text encoding that records of stamps use.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>

#include "protocol/base/digest.h"

namespace fire3dv::scene {

struct FileStamp {
  bool exists = false;
  uint64_t size = 0, inode = 0;
  int64_t modified_ns = 0, changed_ns = 0;  // on the file system's clock
  bool operator==(const FileStamp&) const = default;

  // False if the last write is so close to time_ns that a further write could have the same stamp, because
  // file system clocks tick.
  bool is_settled_at(int64_t time_ns) const;
};

FileStamp stamp_of(const std::filesystem::path& file);

// Digest of a file's contents together with its stamp.
struct StampedDigest {
  Digest digest{};
  FileStamp stamp;
  int64_t taken_ns = 0;  // CLOCK_REALTIME before the stamp, which precedes the digest
  // True only if the contents between taken_ns and now have this digest. Some file systems tick every two
  // seconds, and a file server's clock may be ahead.
  bool holds(const std::filesystem::path& file) const {
    constexpr int64_t kSlowestTick_ns = 5'000'000'000;
    return stamp.exists && stamp_of(file) == stamp && stamp.is_settled_at(taken_ns - kSlowestTick_ns);
  }
};

// Regular files only. Errors are those of digest_of_file().
Result<StampedDigest> stamped_digest_of(const std::filesystem::path& file, uint64_t max_bytes);

// Escapes a name to one line, and back.
std::string escaped(const std::string& text);
std::string unescaped(const std::string& text);

// Space-separated integers. read() returns false for invalid input.
void write(std::ostream& out, const FileStamp& stamp);
bool read(std::istream& in, FileStamp& stamp);

}  // namespace fire3dv::scene
