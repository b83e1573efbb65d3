// What files held when they were read last, kept from one start to the next: a large file is hashed once, and
// again when it has been written.
// That it has been is told by its size, number and times: who puts another file of the same size in its place
// on a file system that has no time of change of its own, and gives it the old one's time, is not noticed.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "renderer/scene/file_stamp.h"

namespace fire3dv::scene {

// Of an asset and the files that belong to it. A record that is damaged, or of another asset, is none.
class KnownDigests {
 public:
  KnownDigests() = default;  // keeps nothing
  KnownDigests(const std::filesystem::path& folder, const std::filesystem::path& asset);

  // Of what the file holds, by its stamp where that is known and settled, else read. The error is
  // digest_of_file's.
  Result<StampedDigest> of(const std::filesystem::path& file, uint64_t max_bytes);

  // Writes down what was read since, or that the record was of use. A fault is no one's concern: the next
  // start reads again.
  void keep();

 private:
  std::filesystem::path record_;                  // empty: nowhere
  std::string asset_;                             // absolute
  std::map<std::string, StampedDigest> digests_;  // by absolute path
  bool learnt_ = false;
};

}  // namespace fire3dv::scene
