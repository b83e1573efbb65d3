#include "protocol/base/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "protocol/base/text.h"

namespace fire3dv {

Result<OpenFile> OpenFile::open(const std::filesystem::path& path, uint64_t max_bytes) {
  // Non-blocking, so that opening a pipe returns and can be refused.
  OpenFile file;
  file.fd_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file.fd_ < 0) return Error{"cannot open " + quote(path.string()) + ": " + std::strerror(errno)};
  struct stat status {};
  if (fstat(file.fd_, &status) != 0)
    return Error{"cannot read " + quote(path.string()) + ": " + std::strerror(errno)};
  if (!S_ISREG(status.st_mode)) return Error{quote(path.string()) + " is not a regular file"};
  file.size_ = static_cast<uint64_t>(status.st_size);
  if (file.size_ > max_bytes) {
    return Error{quote(path.string()) + " holds " + std::to_string(file.size_) + " bytes; at most " +
                 std::to_string(max_bytes) + " are read"};
  }
  return file;
}

OpenFile::OpenFile(OpenFile&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), size_(std::exchange(other.size_, 0)) {}

OpenFile::~OpenFile() {
  if (fd_ >= 0) close(fd_);
}

bool OpenFile::read(uint64_t offset, std::span<std::byte> to) const {
  errno = 0;
  while (!to.empty()) {
    const ssize_t got = pread(fd_, to.data(), to.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got == 0) errno = 0;
    if (got <= 0) return false;
    offset += static_cast<uint64_t>(got);
    to = to.subspan(static_cast<size_t>(got));
  }
  return true;
}

Result<FileBytes> read_file(const std::filesystem::path& path, uint64_t max_bytes) {
  Result<OpenFile> file = OpenFile::open(path, max_bytes);
  if (!file) return file.error();
  FileBytes bytes;
  bytes.size = file->size();
  bytes.data = std::make_unique_for_overwrite<std::byte[]>(bytes.size);
  if (!file->read(0, {bytes.data.get(), bytes.size})) {
    return errno ? Error{"cannot read " + quote(path.string()) + ": " + std::strerror(errno)}
                 : Error{quote(path.string()) + " became shorter while it was read"};
  }
  return bytes;
}

}  // namespace fire3dv
