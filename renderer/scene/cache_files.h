// Files of the caches: storage with eviction of least recently used files, file stamps that detect changed
// source files, and two records of stamps: digests of an asset's files, and conversions to glTF.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/digest.h"
#include "base/error.h"

namespace fire3dv::scene {

// Identity, size and times of a file. It detects changes without reading the contents.
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

// Text encoding of records. Escapes a name to one line, and back.
std::string escaped(const std::string& text);
std::string unescaped(const std::string& text);

// Space-separated integers. read() returns false for invalid input.
void write(std::ostream& out, const FileStamp& stamp);
bool read(std::istream& in, FileStamp& stamp);

// Conversion record of a robot or scene description file: stamps of its sources and of the converted glTF.
// fire3dv-convert writes it; fire3dv validates it before it reuses a conversion.
struct ConversionRecord {
  FileStamp result;
  struct Source {
    std::filesystem::path file;  // absolute in a record
    FileStamp stamp;
  };
  std::vector<Source> sources;
  std::vector<std::string> warnings;  // without line breaks
};

// sources: stamps from before the conversion read them. begun_ns: CLOCK_REALTIME before the first stamp. A
// source written within one clock tick of the file system is recorded as changed, since a second write would
// be invisible.
ConversionRecord record_of(const std::filesystem::path& result,
                           const std::vector<ConversionRecord::Source>& sources, int64_t begun_ns);

std::string text_of(const ConversionRecord& record);
Result<ConversionRecord> read_conversion_record(const std::filesystem::path& file);

// True if the result is the recorded file and all sources are unchanged.
bool holds(const ConversionRecord& record, const std::filesystem::path& result);

// Digests of one asset and its files across program starts: files are hashed again only after they changed.
// Changes are detected by size, inode and times. On a file system without change times, a replaced file with
// equal size and modification time goes undetected. A damaged record, or one of another asset, is ignored.
class DigestCache {
 public:
  DigestCache() = default;  // does not cache
  DigestCache(const std::filesystem::path& folder, const std::filesystem::path& asset);

  // Returns the cached digest if the stamp is known and settled, else hashes the file. Errors are those of
  // digest_of_file().
  Result<StampedDigest> of(const std::filesystem::path& file, uint64_t max_bytes);

  // Writes new digests to the record, or marks the record as used. Errors are ignored: the next start hashes
  // again.
  void store();

 private:
  std::filesystem::path record_;                  // empty: no record
  std::string asset_;                             // absolute path
  std::map<std::string, StampedDigest> digests_;  // by absolute path
  bool has_new_ = false;
};

// Replaces a file atomically, readable by this user only. Contents are flushed to the disk, the name is not:
// a power cut loses the entry or leaves it complete.
Result<void> write_cache_file(const std::filesystem::path& path,
                              const std::vector<std::span<const std::byte>>& pieces);

// Evicts the least recently used files with this ending until the rest has at most max_bytes. Also removes
// temporary files of killed writers. Errors are ignored.
void remove_oldest(const std::filesystem::path& folder, std::string_view ending, uint64_t max_bytes);

// Marks a file as most recently used.
void touch(const std::filesystem::path& path);

}  // namespace fire3dv::scene
