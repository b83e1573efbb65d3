// Reader side of shared-memory segments: every header field is validated on a private copy before use.
#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "protocol/transport/core/link_counters.h"
#include "protocol/transport/shm/shm_segment.h"

namespace fire3dv::transport::shm {
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
