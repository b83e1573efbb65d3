#include "protocol/transport/shm/shm_cleanup.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <memory>
#include <string_view>

#include "protocol/transport/core/fork_guard.h"
#include "protocol/transport/shm/shm_layout.h"
#include "protocol/transport/shm/shm_segment.h"

namespace fire3dv::transport::shm {
namespace {

constexpr const char* kFolder = "/dev/shm";
constexpr std::string_view kPrefix = "fire3dv.", kHiddenPrefix = ".fire3dv.";
constexpr size_t kMaxEntries = 10'000, kMaxSegments = 1'000;

bool is_own_file(const struct stat& info) {
  return S_ISREG(info.st_mode) && info.st_uid == ::geteuid() && (info.st_mode & 077) == 0;
}

}  // namespace

bool remove_dead_segment(const std::string& path) {
  // Holds a lock, which a forked child must not inherit.
  const UnforkableFd fd =
      UnforkableFd::open([&] { return ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK); });
  if (!fd || byte_held_by_other(fd.get(), kPublisherLockByte)) return false;  // living ones cost no more
  struct stat info {};
  if (::fstat(fd.get(), &info) != 0 || !is_own_file(info)) return false;
  SegmentHeader header{};
  if (::pread(fd.get(), &header, sizeof header, 0) != static_cast<ssize_t>(sizeof header) ||
      header.magic != kMagic || header.layout_version != kLayoutVersion)
    return false;
  // As a publisher that takes the name over: a dead one stays dead, so the observation holds.
  if (!try_lock_byte(fd.get(), kTakeOverLockByte) || byte_held_by_other(fd.get(), kPublisherLockByte))
    return false;
  return file_id(path) == file_id(fd.get()) && ::unlink(path.c_str()) == 0;
}

size_t remove_dead_segments(const std::string& except_name) {
  const std::unique_ptr<DIR, int (*)(DIR*)> folder(::opendir(kFolder), ::closedir);
  if (!folder) return 0;
  size_t removed = 0, looked_at = 0;
  for (size_t i = 0; i < kMaxEntries && looked_at < kMaxSegments; ++i) {
    const dirent* const entry = ::readdir(folder.get());
    if (!entry) break;
    const std::string_view name = entry->d_name;
    const bool is_hidden = name.starts_with(kHiddenPrefix);
    if ((!name.starts_with(kPrefix) && !is_hidden) || entry->d_type != DT_REG) continue;
    if (!is_hidden && name.substr(kPrefix.size()) == except_name) continue;
    ++looked_at;
    removed += remove_dead_segment(std::string(kFolder) + "/" + std::string(name));
  }
  return removed;
}

}  // namespace fire3dv::transport::shm
