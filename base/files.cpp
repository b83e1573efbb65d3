#include "base/files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>

namespace fire3dv::base {
namespace {

constexpr int kMaxNameAttempts = 100;
constexpr size_t kRandomLetters = 6;

// Quoted path for messages. A path may contain any byte; control characters must not reach a terminal.
std::string shown(const std::string& path) {
  std::string result = path;
  for (char& c : result)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return result;
}

std::string random_letters() {
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyz0123456789";
  std::array<unsigned char, kRandomLetters> random{};
  for (size_t have = 0; have < random.size();) {
    const ssize_t got = ::getrandom(random.data() + have, random.size() - have, 0);
    if (got > 0) have += static_cast<size_t>(got);
  }
  std::string result;
  for (const unsigned char byte : random) result += kLetters[byte % kLetters.size()];
  return result;
}

// Renames without replacing an existing file. Returns 0 or the error number.
int rename_to_new(const char* from, const char* to) {
  if (::renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  if (::link(from, to) != 0) return errno;  // fallback for file systems without RENAME_NOREPLACE
  ::unlink(from);
  return 0;
}

}  // namespace

Result<void> create_folder(const std::filesystem::path& folder) {
  std::error_code fault;
  std::filesystem::create_directories(folder, fault);
  if (!fault && !std::filesystem::is_directory(folder, fault) && !fault)
    fault = std::make_error_code(std::errc::not_a_directory);
  if (fault == std::errc::not_a_directory || fault == std::errc::file_exists)
    return Error{"cannot make the folder " + folder.string() +
                 ": a file has that name, or is a part of the path; name another folder"};
  if (fault) return Error{"cannot make the folder " + folder.string() + ": " + system_reason(fault.value())};
  return {};
}

std::string system_reason(int error_number) {
  const std::string reason = std::strerror(error_number);
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
      return reason + "; free some, or choose another folder";
    case EACCES:
    case EPERM:
    case EROFS:
      return reason + "; choose a folder that this user may write";
    case EEXIST:
      return reason + "; choose another name, or move that file away";
    case ENOTDIR:
      return reason + "; a part of the path is a file, choose another folder";
    case EFBIG:
      return reason + "; raise the file size limit (ulimit -f)";
    default:
      return reason;
  }
}

int flush(int fd, Flush what) {
  int done = 0;
  do {
    done = what == Flush::data ? ::fdatasync(fd) : ::fsync(fd);
  } while (done != 0 && errno == EINTR);
  if (done == 0 || errno == EINVAL || errno == ENOSYS || errno == ENOTSUP) return 0;
  return errno;
}

int flush_file(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return errno;
  const int fault = flush(fd, Flush::data_and_metadata);
  ::close(fd);
  return fault;
}

int flush_folder_of(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return 0;
  const int fault = flush(fd, Flush::data_and_metadata);
  ::close(fd);
  return fault;
}

AtomicFile::AtomicFile(std::string path, std::string temporary, int fd, const AtomicFileOptions& options)
    : path_(std::move(path)), temporary_(std::move(temporary)), fd_(fd), options_(options) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::move(other.temporary_)),
      fd_(std::exchange(other.fd_, -1)),
      options_(other.options_),
      is_committed_(std::exchange(other.is_committed_, true)) {}

AtomicFile::~AtomicFile() {
  if (fd_ >= 0) ::close(fd_);
  if (!is_committed_) ::unlink(temporary_.c_str());
}

Error AtomicFile::cannot_write(int error_number) const {
  return Error{"cannot write " + shown(path_) + ": " + system_reason(error_number)};
}

Result<AtomicFile> AtomicFile::create(const std::filesystem::path& path, const AtomicFileOptions& options) {
  const auto failed = [&](int error_number) {
    return Error{"cannot write " + shown(path.string()) + ": " + system_reason(error_number)};
  };
  struct stat status {};
  if (!options.replaces && ::lstat(path.c_str(), &status) == 0) return failed(EEXIST);
  for (int attempt = 0; attempt < kMaxNameAttempts; ++attempt) {
    std::string temporary = path.string() + std::string(kTemporaryMark) + random_letters();
    const int fd =
        ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, options.mode);
    if (fd < 0 && errno == EEXIST) continue;
    if (fd < 0) return failed(errno);
    // Some file systems have no modes; a failure has no consequence.
    if (options.exact_mode) (void)!::fchmod(fd, *options.exact_mode);
    // The lock marks a file with a live writer: see remove_abandoned_temporaries(), which may have removed
    // the file before the lock was taken.
    if (::flock(fd, LOCK_EX | LOCK_NB) == 0 && ::fstat(fd, &status) == 0 && status.st_nlink == 0) {
      ::close(fd);
      continue;
    }
    return AtomicFile(path.string(), std::move(temporary), fd, options);
  }
  return failed(EEXIST);
}

Result<void> AtomicFile::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return cannot_write(errno);
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return {};
}

Result<void> AtomicFile::truncate(uint64_t length) {
  if (::ftruncate(fd_, static_cast<off_t>(length)) != 0 ||
      ::lseek(fd_, static_cast<off_t>(length), SEEK_SET) < 0)
    return cannot_write(errno);
  return {};
}

Result<void> AtomicFile::commit() {
  int fault = flush(fd_, Flush::data_and_metadata);
  // Some file systems report a full disk only on close(). The lock lasts until the last duplicate of the
  // descriptor is closed.
  const int copy = ::fcntl(fd_, F_DUPFD_CLOEXEC, 0);
  if (copy >= 0 && ::close(copy) != 0 && fault == 0) fault = errno;
  if (fault != 0) return cannot_write(fault);
  if (options_.replaces)
    fault = ::rename(temporary_.c_str(), path_.c_str()) == 0 ? 0 : errno;
  else
    fault = rename_to_new(temporary_.c_str(), path_.c_str());
  if (fault != 0) return cannot_write(fault);
  is_committed_ = true;
  ::close(std::exchange(fd_, -1));
  if (options_.durability == Durability::contents_and_name)
    if (fault = flush_folder_of(path_); fault != 0)
      return Error{shown(path_) + " is written, but its folder cannot be flushed to the disk: " +
                   std::strerror(fault) + "; check the disk"};
  return {};
}

void remove_abandoned_temporaries(const std::filesystem::path& folder, std::string_view prefix) {
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const size_t mark = name.rfind(kTemporaryMark);
    if (!name.starts_with(prefix) || mark == std::string::npos ||
        name.size() != mark + kTemporaryMark.size() + kRandomLetters)
      continue;
    const int fd = ::open(entry->path().c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) continue;
    if (::flock(fd, LOCK_EX | LOCK_NB) == 0) ::unlink(entry->path().c_str());
    ::close(fd);
  }
}

Result<void> write_atomically(const std::filesystem::path& path,
                              const std::vector<std::span<const std::byte>>& pieces,
                              const AtomicFileOptions& options) {
  Result<AtomicFile> file = AtomicFile::create(path, options);
  if (!file) return file.error();
  for (const std::span<const std::byte>& piece : pieces)
    if (Result<void> appended = file->append(piece); !appended) return appended;
  return file->commit();
}

}  // namespace fire3dv::base

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
