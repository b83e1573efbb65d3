#include "protocol/record/mcap/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "base/files.h"
#include "protocol/record/mcap/named_file.h"
#include "protocol/wire/check.h"

namespace fire3dv::record {
namespace {

// Owner of the descriptor of one open file.
class Fd {
 public:
  explicit Fd(int fd) : fd_(fd) {}
  Fd(Fd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Fd& operator=(Fd&&) = delete;
  ~Fd() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

Error failed(const std::string& name, const char* what, const char* remedy) {
  return Error{wire::printable(name, 4096) + " cannot be " + what + ": " + std::strerror(errno) + "; " +
               remedy};
}

class FileSource final : public Source {
 public:
  FileSource(Fd fd, uint64_t size, std::string path)
      : fd_(std::move(fd)), size_(size), path_(std::move(path)) {}
  uint64_t size() const override { return size_; }
  const std::string& name() const override { return path_; }
  Result<void> read(uint64_t offset, std::span<std::byte> to) override {
    while (!to.empty()) {
      const ssize_t got = ::pread(fd_.get(), to.data(), to.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return failed(path_, "read", "look at the disk");
      if (got == 0)
        return Error{wire::printable(path_, 4096) + " has become shorter while it was read; try again"};
      offset += static_cast<uint64_t>(got);
      to = to.subspan(static_cast<size_t>(got));
    }
    return {};
  }

 private:
  Fd fd_;
  uint64_t size_;
  std::string path_;
};

class FileSink final : public Sink {
 public:
  FileSink(Fd fd, std::string path) : fd_(std::move(fd)), path_(std::move(path)) {}
  const std::string& name() const override { return path_; }
  Result<void> append(std::span<const std::byte> bytes) override {
    while (!bytes.empty()) {
      const ssize_t put = ::write(fd_.get(), bytes.data(), bytes.size());
      if (put < 0 && errno == EINTR) continue;
      if (put <= 0) return failed(path_, "written", "make room, or record elsewhere");
      bytes = bytes.subspan(static_cast<size_t>(put));
    }
    return {};
  }
  Result<void> truncate(uint64_t length) override {
    if (::ftruncate(fd_.get(), static_cast<off_t>(length)) != 0 ||
        ::lseek(fd_.get(), static_cast<off_t>(length), SEEK_SET) < 0)
      return failed(path_, "cut back to its last whole chunk", "fire3dv-record recover mends it");
    return {};
  }
  Result<void> flush() override { return flush(base::Flush::data); }
  Result<void> finish() override {
    const Result<void> flushed = flush(base::Flush::data_and_metadata);
    return flushed ? check_name() : flushed;
  }
  Result<void> check_name() const override { return check_name_of(fd_.get(), path_); }

 private:
  // The first flush includes the folder entry: without the name the contents would be lost.
  Result<void> flush(base::Flush what) {
    int fault = base::flush(fd_.get(), what);
    if (fault == 0 && !name_is_flushed_) fault = base::flush_folder_of(path_);
    if (fault == 0) {
      name_is_flushed_ = true;
      return {};
    }
    return Error{wire::printable(path_, 4096) + " cannot be flushed to the disk: " + std::strerror(fault) +
                 "; check the disk, then run fire3dv-record recover: data written since the last flush may "
                 "be lost"};
  }

  Fd fd_;
  std::string path_;
  bool name_is_flushed_ = false;
};

class AtomicSink final : public Sink {
 public:
  AtomicSink(base::AtomicFile file, std::string path) : file_(std::move(file)), path_(std::move(path)) {}
  const std::string& name() const override { return path_; }
  Result<void> append(std::span<const std::byte> bytes) override { return file_.append(bytes); }
  Result<void> truncate(uint64_t length) override { return file_.truncate(length); }
  Result<void> finish() override { return file_.commit(); }

 private:
  base::AtomicFile file_;
  std::string path_;
};

}  // namespace

Result<std::unique_ptr<Source>> open_source(const std::string& path) {
  // O_NONBLOCK: opening a pipe without a writer would block.
  Fd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (fd.get() < 0) return failed(path, "opened", "check the name");
  struct stat status {};
  if (::fstat(fd.get(), &status) != 0) return failed(path, "read", "look at the disk");
  if (!S_ISREG(status.st_mode))
    return Error{wire::printable(path, 4096) + " is not a regular file; name a recording"};
  return std::unique_ptr<Source>(
      std::make_unique<FileSource>(std::move(fd), static_cast<uint64_t>(status.st_size), path));
}

Result<std::unique_ptr<Sink>> create_sink(const std::string& path) {
  Fd fd(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (fd.get() < 0 && errno == EEXIST)
    return Error{wire::printable(path, 4096) + " is there already; name another file, or move that one away"};
  if (fd.get() < 0) return failed(path, "made", "check the folder");
  return std::unique_ptr<Sink>(std::make_unique<FileSink>(std::move(fd), path));
}

Result<std::unique_ptr<Sink>> create_atomic_sink(const std::string& path) {
  auto file = base::AtomicFile::create(path, {.replaces = false});
  if (!file) return file.error();
  return std::unique_ptr<Sink>(std::make_unique<AtomicSink>(std::move(*file), path));
}

Result<void> MemorySource::read(uint64_t offset, std::span<std::byte> to) {
  if (offset > bytes_.size() || to.size() > bytes_.size() - offset) return Error{name_ + " ends before that"};
  if (!to.empty()) std::memcpy(to.data(), bytes_.data() + offset, to.size());
  return {};
}

Result<void> MemorySink::append(std::span<const std::byte> bytes) {
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  return {};
}

Result<void> MemorySink::truncate(uint64_t length) {
  bytes_.resize(static_cast<size_t>(length));
  return {};
}

}  // namespace fire3dv::record
