#include "renderer/sinks/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace fire3dv::sinks {
namespace {

struct Descriptor {
  int fd = -1;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
  Descriptor(int opened) : fd(opened) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
};

int write_all(int fd, std::span<const uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return 0;
}

}  // namespace

std::string system_reason(int error_number) {
  std::string reason = std::strerror(error_number);
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
      return reason + "; free some, or choose another folder";
    case EACCES:
    case EPERM:
    case EROFS:
      return reason + "; choose a folder that this user may write";
    case ENOTDIR:
      return reason + "; a part of the path is a file, choose another folder";
    case EFBIG:
      return reason + "; raise the file size limit (ulimit -f)";
    default:
      return reason;
  }
}

int open_new(const std::filesystem::path& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) return -1;
  return ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
}

Result<void> write_whole_file(const std::filesystem::path& path, std::span<const uint8_t> bytes) {
  const std::string part = path.string() + ".part";
  const auto failed = [&](int error_number) {
    return Error{"cannot write " + path.string() + ": " + system_reason(error_number)};
  };
  {
    Descriptor file(open_new(part));
    if (file.fd < 0) return failed(errno);
    int fault = write_all(file.fd, bytes);
    if (::close(file.fd) != 0 && fault == 0)
      fault = errno;  // some file systems tell of a full disk only here
    file.fd = -1;
    if (fault != 0) {
      ::unlink(part.c_str());
      return failed(fault);
    }
  }
  if (::rename(part.c_str(), path.c_str()) != 0) {
    const int fault = errno;
    ::unlink(part.c_str());
    return failed(fault);
  }
  return {};
}

Result<std::vector<uint8_t>> read_whole_file(const std::filesystem::path& path, uint64_t max_bytes) {
  const auto failed = [&](const std::string& reason) {
    return Error{"cannot read " + path.string() + ": " + reason};
  };
  // O_NONBLOCK: a named pipe in the place of a file must not hold us up; it is refused below.
  Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.fd < 0) return failed(std::strerror(errno));
  struct stat about {};
  if (::fstat(file.fd, &about) != 0) return failed(std::strerror(errno));
  if (!S_ISREG(about.st_mode)) return failed("it is not a file");
  if (static_cast<uint64_t>(about.st_size) > max_bytes)
    return failed("it is larger than " + std::to_string(max_bytes) + " bytes");
  std::vector<uint8_t> bytes(static_cast<size_t>(about.st_size));
  size_t have = 0;
  while (have < bytes.size()) {
    const ssize_t got = ::read(file.fd, bytes.data() + have, bytes.size() - have);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return failed(std::strerror(errno));
    if (got == 0) break;
    have += static_cast<size_t>(got);
  }
  bytes.resize(have);
  return bytes;
}

}  // namespace fire3dv::sinks
