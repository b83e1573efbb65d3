#include "convert/glb/output.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "base/files.h"
#include "base/text.h"
#include "renderer/scene/cache_files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

// Resolves symbolic links, even if the target does not exist.
fs::path followed(fs::path path) {
  constexpr int kMaxLinks = 40;  // limit of the kernel
  std::error_code error;
  for (int i = 0; i < kMaxLinks && fs::is_symlink(path, error); ++i)
    path = path.parent_path() / fs::read_symlink(path, error);
  return path;
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
  const fs::path target = followed(path);
  struct stat status {};
  if (::stat(target.c_str(), &status) != 0) return base::write_atomically(target, {bytes});
  if (S_ISREG(status.st_mode))
    return base::write_atomically(target, {bytes}, {.exact_mode = status.st_mode & 0777});
  const int fd = ::open(target.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
  if (fd < 0) return cannot_write(path, std::strerror(errno));
  Result<void> done = write_descriptor(fd, bytes);
  if (::close(fd) != 0 && done) done = Error{std::strerror(errno)};
  return done ? done : cannot_write(path, done.error().message);
}

Result<void> write_cache_entry(const fs::path& path, std::span<const std::byte> bytes) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_symlink(status))
    return cannot_write(path, "it is there, and is not a regular file");
  return scene::write_cache_file(path, {bytes});
}

}  // namespace fire3dv::convert
