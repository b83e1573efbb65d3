#include "protocol/base/file_io.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace fire3dv {
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

}  // namespace

Result<void> write_whole_file(const std::filesystem::path& path, std::span<const uint8_t> bytes,
                              base::Durability durability) {
  return base::write_atomically(path, {std::as_bytes(bytes)}, {.durability = durability});
}

Result<std::vector<uint8_t>> read_whole_file(const std::filesystem::path& path, uint64_t max_bytes) {
  const auto failed = [&](const std::string& reason) {
    return Error{"cannot read " + path.string() + ": " + reason};
  };
  // O_NONBLOCK: opening a named pipe must not block; it is refused below.
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

}  // namespace fire3dv
