#include "protocol/transport/shm/shm_segment.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <boost/interprocess/mapped_region.hpp>
#include <cerrno>
#include <cstring>
#include <exception>

namespace fire3dv::transport::shm {
namespace {

namespace bip = boost::interprocess;

// Adapter of a descriptor to Boost.Interprocess. The file is opened here because owner, mode and size must be
// checked on the mapped descriptor.
struct MappableFile {
  int fd;
  bip::mapping_handle_t get_mapping_handle() const {
    return bip::ipcdetail::mapping_handle_from_file_handle(fd);
  }
  bip::mode_t get_mode() const { return bip::read_write; }
};

struct flock one_byte(short type, int64_t byte) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = byte;
  lock.l_len = 1;
  return lock;
}

}  // namespace

Mapping Mapping::of(int fd, size_t bytes, bool touch_all_pages) {
  Mapping mapping;
  try {
    auto region = std::make_shared<bip::mapped_region>(
        MappableFile{fd}, bip::read_write, 0, bytes, nullptr,
        touch_all_pages ? bip::map_options_t{MAP_POPULATE} : bip::default_map_options);
    mapping.base_ = static_cast<std::byte*>(region->get_address());
    mapping.region_ = std::move(region);
  } catch (const bip::interprocess_exception& exception) {
    errno = exception.get_native_error();
  } catch (const std::exception&) {
    errno = ENOMEM;
  }
  return mapping;
}

std::string segment_path(const std::string& name) {
  return "/dev/shm/fire3dv." + name;
}

UnforkableFd open_again(int fd) {
  const std::string path = "/proc/self/fd/" + std::to_string(fd);
  return UnforkableFd::open([&] { return ::open(path.c_str(), O_RDWR | O_CLOEXEC); });
}

// Open-file-description locks: closing another descriptor of the file does not release them, and two links in
// one process exclude each other like two processes.
bool try_lock_byte(int fd, int64_t byte) {
  struct flock lock = one_byte(F_WRLCK, byte);
  return ::fcntl(fd, F_OFD_SETLK, &lock) == 0;
}

void unlock_byte(int fd, int64_t byte) {
  struct flock lock = one_byte(F_UNLCK, byte);
  ::fcntl(fd, F_OFD_SETLK, &lock);
}

bool byte_held_by_other(int fd, int64_t byte) {
  struct flock lock = one_byte(F_WRLCK, byte);
  return ::fcntl(fd, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

FileId file_id(int fd) {
  struct stat info {};
  if (::fstat(fd, &info) != 0) return {};
  return {info.st_dev, info.st_ino};
}

FileId file_id(const std::string& path) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0) return {};
  return {info.st_dev, info.st_ino};
}

}  // namespace fire3dv::transport::shm
