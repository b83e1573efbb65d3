#include "renderer/scene/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>

#include "renderer/scene/files.h"

namespace fire3dv::scene {
namespace {

constexpr std::string_view kPartMark = ".part-";
constexpr std::chrono::hours kPartLifetime{1};

bool write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return true;
}

}  // namespace

Result<void> write_atomically(const std::filesystem::path& path,
                              const std::vector<std::span<const std::byte>>& pieces, mode_t mode) {
  const auto failed = [&](int fault) {
    return Error{"cannot write " + quote(path.string()) + ": " + std::strerror(fault)};
  };
  std::string part = path.string() + std::string(kPartMark) + "XXXXXX";
  const int fd = ::mkostemp(part.data(), O_CLOEXEC);
  if (fd < 0) return failed(errno);
  int fault = 0;
  for (const std::span<const std::byte>& piece : pieces) {
    if (fault == 0 && !write_all(fd, piece)) fault = errno;
  }
  ::fchmod(fd, mode);  // some file systems know no modes: then there is nothing to keep
  if (::close(fd) != 0 && fault == 0) fault = errno;  // some file systems tell of a full disk only here
  if (fault == 0 && ::rename(part.c_str(), path.c_str()) != 0) fault = errno;
  if (fault == 0) return {};
  ::unlink(part.c_str());
  return failed(fault);
}

void remove_oldest(const std::filesystem::path& folder, std::string_view ending, uint64_t most_bytes) {
  namespace fs = std::filesystem;
  struct Kept {
    fs::path path;
    fs::file_time_type used;
    uint64_t bytes;
  };
  std::vector<Kept> all;
  uint64_t bytes = 0;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code fault;
    const std::string name = entry->path().filename().string();
    if (entry->is_symlink(fault) || !entry->is_regular_file(fault)) continue;
    const auto used = entry->last_write_time(fault);
    const uint64_t size = fault ? 0 : entry->file_size(fault);
    if (fault) continue;
    const size_t mark = name.rfind(kPartMark);
    if (mark != std::string::npos && name.substr(0, mark).ends_with(ending)) {
      if (fs::file_time_type::clock::now() - used > kPartLifetime) fs::remove(entry->path(), fault);
    } else if (name.ends_with(ending)) {
      all.push_back({entry->path(), used, size});
      bytes += size;
    }
  }
  std::sort(all.begin(), all.end(), [](const Kept& a, const Kept& b) { return a.used < b.used; });
  for (const Kept& kept : all) {
    if (bytes <= most_bytes) return;
    std::error_code fault;
    if (fs::remove(kept.path, fault)) bytes -= kept.bytes;
  }
}

void touch(const std::filesystem::path& path) {
  ::utimensat(AT_FDCWD, path.c_str(), nullptr, AT_SYMLINK_NOFOLLOW);
}

}  // namespace fire3dv::scene
