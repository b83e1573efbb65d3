#include "protocol/transport/shm/shm_segment.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <boost/interprocess/mapped_region.hpp>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <exception>
#include <thread>

#include "base/random.h"
#include "protocol/transport/core/link_counters.h"

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

// --- publisher: layout, creation, and takeover of a name.

namespace {

constexpr uint64_t kControlSlots = 16;
constexpr uint64_t kControlBytes = 4096 - kSlotHeaderBytes;

uint64_t round_up(uint64_t value, uint64_t to) {
  return (value + to - 1) / to * to;
}

RingGeometry place_ring(uint64_t& end, uint64_t capacity, uint64_t count) {
  RingGeometry ring{};
  ring.offset = end;
  ring.capacity = capacity;
  ring.stride = round_up(kSlotHeaderBytes + capacity, 64);
  ring.count = count;
  end += ring.stride * count;
  return ring;
}

SegmentHeader lay_out(const SegmentSizes& sizes, uint64_t publisher_id) {
  SegmentHeader header{};
  header.magic = kMagic;
  header.layout_version = kLayoutVersion;
  header.header_bytes = kHeaderBytes;
  header.publisher_id = publisher_id;
  header.publisher_pid = static_cast<uint32_t>(::getpid());
  header.reader_count = kReaderCount;
  header.reader_stride = sizeof(ReaderSlot);
  uint64_t end = kHeaderBytes;
  header.readers_offset = end;
  end += kReaderCount * sizeof(ReaderSlot);
  header.rings[kDescriptionRing] = place_ring(end, sizes.description_bytes, 2);
  header.rings[kControlRing] = place_ring(end, kControlBytes, kControlSlots);
  header.rings[kPoseRing] = place_ring(end, sizes.pose_bytes, std::bit_ceil(sizes.pose_slots));
  header.states = {end, round_up(sizes.state_bytes, 64)};
  end += 2 * header.states.half_bytes;
  if (sizes.image_slots != 0) header.images = place_ring(end, sizes.image_bytes, sizes.image_slots);
  header.segment_bytes = round_up(end, 4096);
  return header;
}

Error system_error(const std::string& name, const std::string& what, int error) {
  return Error{"shm://" + name + ": " + what + ": " + std::strerror(error)};
}

Error no_room(const std::string& name, uint64_t bytes) {
  return Error{"shm://" + name + ": /dev/shm has no room for " +
               std::to_string((bytes + (1 << 20) - 1) >> 20) +
               " MiB; remove files from it or mount it larger (docker run --shm-size 1g)"};
}

std::string fd_path(int fd) {
  return "/proc/self/fd/" + std::to_string(fd);
}

bool link_as(int fd, const std::string& path) {
  return ::linkat(AT_FDCWD, fd_path(fd).c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) == 0;
}

// Atomically replaces the file of that name: a reader opens either the old segment or the new one.
Result<void> rename_over(int fd, const std::string& name) {
  char suffix[32];
  std::snprintf(suffix, sizeof suffix, ".%016llx", static_cast<unsigned long long>(random_id()));
  const std::string temporary = "/dev/shm/.fire3dv." + name + suffix;
  if (!link_as(fd, temporary)) return system_error(name, "cannot name a segment in /dev/shm", errno);
  if (::rename(temporary.c_str(), segment_path(name).c_str()) != 0) {
    const int error = errno;
    ::unlink(temporary.c_str());
    return system_error(name, "cannot replace " + segment_path(name), error);
  }
  return {};
}

Error busy(const std::string& name, int fd) {
  SegmentHeader header{};
  std::string by = "another process";
  if (::pread(fd, &header, sizeof header, 0) == sizeof header && header.magic == kMagic)
    by = "process " + std::to_string(header.publisher_pid);
  return Error{"shm://" + name + " is being published by " + by + "; stop it or choose another name"};
}

// Result of competing for a name that another or dead publisher's file has. gone: the file changed, try
// again.
enum class EpochConflict { won, gone, lost };
Result<EpochConflict> contest_name(const Segment& segment, const std::string& name, bool last_try) {
  const std::string path = segment_path(name);
  // Holds a lock, which a forked child must not inherit.
  const UnforkableFd old =
      UnforkableFd::open([&] { return ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK); });
  if (!old) {
    if (errno == ENOENT) return EpochConflict::gone;
    return system_error(name, "cannot replace " + path + ", which somebody else made; choose another name",
                        errno);
  }
  struct stat info {};
  if (::fstat(old.get(), &info) != 0 || !S_ISREG(info.st_mode))
    return Error{"shm://" + name + ": " + path + " is not a regular file; choose another name"};
  // Serialises contenders. A dead publisher stays dead, so the observation holds until the rename.
  if (!try_lock_byte(old.get(), kTakeOverLockByte) || byte_held_by_other(old.get(), kPublisherLockByte)) {
    if (last_try) return busy(name, old.get());
    return EpochConflict::lost;
  }
  // Another publisher may have taken the name between open and lock.
  if (file_id(path) != file_id(old.get())) return EpochConflict::gone;
  if (auto renamed = rename_over(segment.fd.get(), name); !renamed) return renamed.error();
  return EpochConflict::won;
}

}  // namespace

Result<Segment> create_segment(const std::string& name, const SegmentSizes& sizes, uint64_t publisher_id) {
  Segment segment;
  segment.geometry = lay_out(sizes, publisher_id);
  const uint64_t bytes = segment.geometry.segment_bytes;
  // Unnamed file: a publisher killed during initialisation leaves nothing behind.
  segment.fd = UniqueFd(::open("/dev/shm", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600));
  if (!segment.fd) return system_error(name, "cannot make a segment in /dev/shm", errno);
  if (::fchmod(segment.fd.get(), 0600) != 0)
    return system_error(name, "cannot set the segment's mode", errno);
  int error = EINTR;
  while (error == EINTR) error = ::posix_fallocate(segment.fd.get(), 0, static_cast<off_t>(bytes));
  if (error == ENOSPC || error == EFBIG || error == ENOMEM) return no_room(name, bytes);
  if (error != 0) return system_error(name, "cannot reserve memory in /dev/shm", error);
  segment.mapping = Mapping::of(segment.fd.get(), bytes, true);
  if (!segment.mapping) return system_error(name, "cannot map the segment", errno);
  std::memcpy(segment.mapping.base(), &segment.geometry, sizeof(SegmentHeader));
  segment.lock_fd = open_again(segment.fd.get());
  if (!segment.lock_fd || !try_lock_byte(segment.lock_fd.get(), kPublisherLockByte))
    return system_error(name, "cannot lock the segment", errno);
  return segment;
}

Result<void> take_name(const Segment& segment, const std::string& name, bool replace_own) {
  if (replace_own) return rename_over(segment.fd.get(), name);
  // Retries: another publisher may be taking over or leaving concurrently.
  constexpr int kTries = 20;
  for (int i = 0; i < kTries; ++i) {
    if (link_as(segment.fd.get(), segment_path(name))) return {};
    if (errno != EEXIST) return system_error(name, "cannot name a segment in /dev/shm", errno);
    const Result<EpochConflict> contest = contest_name(segment, name, i + 1 == kTries);
    if (!contest) return contest.error();
    if (*contest == EpochConflict::won) return {};
    if (*contest == EpochConflict::lost) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return Error{"shm://" + name + ": another publisher keeps taking the name; stop it or choose another"};
}

void drop_name(const Segment& segment, const std::string& name) {
  const std::string path = segment_path(name);
  if (file_id(path) == file_id(segment.fd.get())) ::unlink(path.c_str());
}

// --- reader: every header field is validated on a private copy before use.

namespace {

constexpr uint64_t kMaxSlots = 1024;

Error refuse(const std::string& name, const std::string& why) {
  return Error{"shm://" + name + ": " + segment_path(name) + " " + why};
}

bool inside(uint64_t offset, uint64_t bytes, uint64_t total) {
  return offset <= total && bytes <= total - offset;
}

bool ring_is_sound(const RingGeometry& ring, uint64_t segment_bytes) {
  return ring.count >= 2 && ring.count <= kMaxSlots && std::has_single_bit(ring.count) &&
         ring.capacity <= kMaxMessageBytes && ring.stride % 64 == 0 && ring.stride >= kSlotHeaderBytes &&
         ring.stride <= kMaxMessageBytes * 2 &&
         ring.stride - kSlotHeaderBytes >= (ring.capacity + 7) / 8 * 8 && ring.offset % 64 == 0 &&
         ring.offset >= kHeaderBytes &&
         inside(ring.offset, ring.count * ring.stride, segment_bytes);  // at most 2^10 * 2^29: no overflow
}

bool states_are_sound(const StatesGeometry& states, uint64_t segment_bytes) {
  constexpr uint64_t kMaxHalfBytes = uint64_t{4} * kMaxMessageBytes;
  return states.half_bytes == 0 ||
         (states.half_bytes <= kMaxHalfBytes && states.half_bytes % 64 == 0 && states.offset % 64 == 0 &&
          states.offset >= kHeaderBytes && inside(states.offset, 2 * states.half_bytes, segment_bytes));
}

bool images_are_sound(const RingGeometry& images, uint64_t segment_bytes) {
  return images.count == 0 ||
         (images.count <= kMaxImageSlots && images.capacity <= kMaxMessageBytes && images.stride % 64 == 0 &&
          images.stride <= kMaxMessageBytes * 2 && images.stride >= kSlotHeaderBytes &&
          images.stride - kSlotHeaderBytes >= images.capacity && images.offset % 64 == 0 &&
          images.offset >= kHeaderBytes &&
          inside(images.offset, images.count * images.stride, segment_bytes));
}

Result<void> check_file(const std::string& name, const struct stat& info) {
  if (!S_ISREG(info.st_mode)) return refuse(name, "is not a regular file; remove it or choose another name");
  if (info.st_uid != ::geteuid() && info.st_uid != 0)
    return refuse(name, "belongs to user " + std::to_string(info.st_uid) +
                            ", not to you; run simulator and renderer as the same user");
  if ((info.st_mode & 077) != 0)
    return refuse(name,
                  "may be written or read by other users; remove it, so that the simulator makes a safe one");
  return {};
}

Result<void> check_header(const std::string& name, const SegmentHeader& header, uint64_t file_bytes) {
  if (header.magic != kMagic)
    return refuse(name, "is not a FIRE-3DV segment; remove it or choose another name");
  if (header.layout_version != kLayoutVersion)
    return refuse(name, "has layout version " + std::to_string(header.layout_version) +
                            ", this program reads " + std::to_string(kLayoutVersion) +
                            "; use the same version on both sides");
  if (header.segment_bytes != file_bytes)
    return refuse(name, "is " + std::to_string(file_bytes) + " bytes long; its header states " +
                            std::to_string(header.segment_bytes) + "; restart the simulator");
  bool sound = header.header_bytes == kHeaderBytes && header.reader_count == kReaderCount &&
               header.reader_stride == sizeof(ReaderSlot) && header.readers_offset % 64 == 0 &&
               header.readers_offset >= kHeaderBytes &&
               inside(header.readers_offset, kReaderCount * sizeof(ReaderSlot), file_bytes);
  for (const RingGeometry& ring : header.rings) sound = sound && ring_is_sound(ring, file_bytes);
  sound = sound && states_are_sound(header.states, file_bytes) && images_are_sound(header.images, file_bytes);
  if (!sound) return refuse(name, "has a damaged header; restart the simulator");
  return {};
}

}  // namespace

Result<Found> find_segment(const std::string& name, FileId& seen) {
  Found found;
  seen = {};
  const std::string path = segment_path(name);
  UniqueFd fd(::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!fd) {
    const int error = errno;
    if (error == ENOENT) return found;
    seen = file_id(path);
    return refuse(name, std::string("cannot be opened (") + std::strerror(error) +
                            "); run simulator and renderer as the same user");
  }
  struct stat info {};
  if (::fstat(fd.get(), &info) != 0) return refuse(name, "cannot be looked at; choose another name");
  seen = found.id = {info.st_dev, info.st_ino};
  if (auto file = check_file(name, info); !file) return file.error();
  const uint64_t file_bytes = static_cast<uint64_t>(info.st_size);
  if (file_bytes < kHeaderBytes || ::pread(fd.get(), &found.segment.geometry, sizeof(SegmentHeader), 0) !=
                                       static_cast<ssize_t>(sizeof(SegmentHeader)))
    return refuse(name, "is too short for a FIRE-3DV segment; remove it or choose another name");
  if (auto header = check_header(name, found.segment.geometry, file_bytes); !header) return header.error();
  if (!byte_held_by_other(fd.get(), kPublisherLockByte)) return found;  // the publisher is dead
  found.segment.mapping = Mapping::of(fd.get(), file_bytes, false);
  if (!found.segment.mapping) return refuse(name, std::string("cannot be mapped: ") + std::strerror(errno));
  found.segment.lock_fd = open_again(fd.get());
  if (!found.segment.lock_fd) return refuse(name, std::string("cannot be opened: ") + std::strerror(errno));
  found.segment.fd = std::move(fd);
  return found;
}

}  // namespace fire3dv::transport::shm
