// Digest cache across program starts: an asset's files are hashed again only after they changed. Changes are
// detected by size, inode and times. On a file system without change times, a replaced file with equal size
// and modification time goes undetected.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "renderer/scene/cache/file_stamp.h"

namespace fire3dv::scene {

// Digests of one asset and its files. A damaged record, or one of another asset, is ignored.
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

}  // namespace fire3dv::scene
