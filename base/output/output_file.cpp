#include "base/output/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <system_error>

#include "base/files.h"
#include "base/numbers.h"
#include "base/text.h"

namespace fire3dv::base {
namespace {

namespace fs = std::filesystem;

// Where a name leads: an open descriptor of this process, or a path without symbolic links at its end, whose
// file may not exist.
struct Target {
  std::optional<int> fd;
  fs::path path;
};
Target find_target(fs::path path) {
  constexpr int kMaxLinks = 40;  // limit of the kernel
  std::error_code error;
  for (int i = 0; i < kMaxLinks && fs::is_symlink(path, error); ++i) {
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    if (fs::equivalent(folder, "/proc/self/fd", error))
      return {parse_number<int>(path.filename().string()), path};
    path = path.parent_path() / fs::read_symlink(path, error);
  }
  return {std::nullopt, path};
}

Error cannot_write(const fs::path& path, const std::string& why) {
  return Error{"cannot write " + quote(path.string()) + ": " + why};
}

}  // namespace

Result<void> write_descriptor(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return Error{std::strerror(errno)};
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return {};
}

Result<void> write_output(const fs::path& path, std::span<const std::byte> bytes) {
  const Target target = find_target(path);
  // The file behind a descriptor has contents of other writers: it is continued, not replaced.
  if (target.fd) {
    const Result<void> done = write_descriptor(*target.fd, bytes);
    return done ? done : cannot_write(path, done.error().message);
  }
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (!exists && errno != ENOENT) return cannot_write(path, std::strerror(errno));
  if (!exists) return write_atomically(target.path, {bytes});
  if (S_ISREG(status.st_mode))
    return write_atomically(target.path, {bytes}, {.exact_mode = status.st_mode & 0777});
  const int fd = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
  if (fd < 0) return cannot_write(path, std::strerror(errno));
  Result<void> done = write_descriptor(fd, bytes);
  if (::close(fd) != 0 && done) done = Error{std::strerror(errno)};
  return done ? done : cannot_write(path, done.error().message);
}

bool is_open_as(int fd, const fs::path& path) {
  struct stat open {
  }, named{};
  return ::fstat(fd, &open) == 0 && ::stat(path.c_str(), &named) == 0 && open.st_dev == named.st_dev &&
         open.st_ino == named.st_ino;
}

}  // namespace fire3dv::base
