// Watch of files by their time stamps: polling also sees files that are replaced by a rename, and files of
// network folders. A change is reported once the files have been quiet for a while.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "renderer/scene/cache_files.h"

namespace fire3dv::app {

// A file with its stamp from before it was read.
struct WatchedFile {
  std::filesystem::path file;
  scene::FileStamp stamp;
};

class FileWatch {
 public:
  static constexpr int64_t kPeriod_ns = 500'000'000;      // between two looks at the files
  static constexpr int64_t kBusyPeriod_ns = 100'000'000;  // while a change settles
  static constexpr int64_t kQuiet_ns = 300'000'000;       // size and times are equal for so long

  // The first file must exist, or the change is not complete.
  explicit FileWatch(std::vector<WatchedFile> files) : files_(std::move(files)) {}

  // Returns true once for each change that has settled. Cheap: most calls compare two times. now_ns:
  // monotonic clock.
  bool poll(int64_t now_ns);

  // Watches these files from now on. Of those that it watches already, the stamps of the last change count,
  // which precede the load that it caused.
  void watch(std::vector<WatchedFile> files);

 private:
  std::vector<WatchedFile> files_;
  std::vector<scene::FileStamp> seen_;  // of a change that has not settled; empty: none
  int64_t seen_ns_ = 0, next_ns_ = 0;
};

}  // namespace fire3dv::app
