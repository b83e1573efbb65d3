// Writer of a recording of one stream: description, whole frames, and goodbye. Equal calls give equal bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "base/error.h"
#include "protocol/record/mcap/file.h"
#include "protocol/record/stream_log.h"
#include "protocol/wire/affine.h"
#include "protocol/wire/messages.h"

namespace fire3dv::imported {

class StreamWriter {
 public:
  // Name and epoch of the description are replaced. time_ns: not after that of the first frame.
  static Result<StreamWriter> open(std::unique_ptr<record::Sink> sink, wire::StreamDescription description,
                                   int64_t time_ns);

  // Times rise and are not negative. poses: one for each node. Fails for elements beyond 1e12.
  Result<void> write(int64_t time_ns, std::span<const wire::Affine3x4> poses);
  Result<void> finish();

  uint64_t frames() const { return sequence_; }
  int64_t first_ns() const { return first_ns_; }  // of the frames
  int64_t last_ns() const { return last_ns_; }

 private:
  Result<void> take(std::span<const std::byte> message, int64_t time_ns);

  std::unique_ptr<record::StreamLog> log_;
  uint64_t sequence_ = 0;
  int64_t first_ns_ = 0, last_ns_ = 0;
};

}  // namespace fire3dv::imported
