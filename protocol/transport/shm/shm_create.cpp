// Publisher side of shared-memory segments: layout, creation, and takeover of a name.
#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <thread>

#include "protocol/base/random.h"
#include "protocol/transport/shm/shm_segment.h"

namespace fire3dv::transport::shm {
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
               " MiB; remove stale files from it or mount it larger"};
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
  if (error != 0) return system_error(name, "cannot set memory aside in /dev/shm", error);
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

}  // namespace fire3dv::transport::shm
