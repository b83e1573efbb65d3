#include "renderer/loading/file_watch.h"

#include <algorithm>
#include <utility>

namespace fire3dv::app {
namespace {

// Change times are left out: another link or mode leaves the contents as they are.
bool is_same(const scene::FileStamp& a, const scene::FileStamp& b) {
  return a.exists == b.exists && a.size == b.size && a.inode == b.inode && a.modified_ns == b.modified_ns;
}

}  // namespace

void FileWatch::watch(std::vector<WatchedFile> files) {
  for (WatchedFile& each : files) {
    const auto known = std::find_if(files_.begin(), files_.end(),
                                    [&](const WatchedFile& before) { return before.file == each.file; });
    if (known != files_.end()) each.stamp = known->stamp;
  }
  files_ = std::move(files);
  seen_.clear();
}

bool FileWatch::poll(int64_t now_ns) {
  if (now_ns < next_ns_ || files_.empty()) return false;
  std::vector<scene::FileStamp> stamps;
  bool changed = false;
  for (const WatchedFile& watched : files_) {
    stamps.push_back(scene::stamp_of(watched.file));
    changed |= !is_same(stamps.back(), watched.stamp);
  }
  next_ns_ = now_ns + (changed ? kBusyPeriod_ns : kPeriod_ns);
  if (!changed) {
    seen_.clear();
    return false;
  }
  if (seen_.empty() || !std::equal(stamps.begin(), stamps.end(), seen_.begin(), is_same)) {
    seen_ = std::move(stamps);
    seen_ns_ = now_ns;
    return false;
  }
  if (!seen_.front().exists || now_ns - seen_ns_ < kQuiet_ns) return false;
  for (size_t i = 0; i < files_.size(); ++i) files_[i].stamp = seen_[i];
  seen_.clear();
  return true;
}

}  // namespace fire3dv::app
