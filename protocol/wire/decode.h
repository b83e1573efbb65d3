// Bytes to messages. The FlatBuffers verifier runs in decode.cpp and nowhere else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "protocol/error.h"
#include "protocol/wire/messages.h"

namespace fire3dv::wire {

// What a message may hold before it is refused. The defaults suit a renderer; tests lower them.
struct DecodeLimits {
  size_t max_message_bytes = 256u << 20;
  uint32_t max_nodes = 1u << 20;
  uint32_t max_name_bytes = 1024;  // of a node's, adapter's or renderer's name
  uint32_t max_text_bytes = 4096;  // of a URI or a message for people
  float max_abs_value = 1e12f;     // of a pose element: larger is refused as nonsense, like NaN and infinity
};

// Of an image request: what an answer has to name.
struct ImageRequestName {
  uint64_t epoch = 0, id = 0;
};

// Owns a private aligned copy of the bytes being decoded, so that neither alignment nor a writer that changes
// shared memory after the check can hurt. One decoder per thread; the copy's memory is reused.
class Decoder {
 public:
  explicit Decoder(DecodeLimits limits = {});
  ~Decoder();
  Decoder(Decoder&&) noexcept;
  Decoder& operator=(Decoder&&) noexcept;

  // Structure first, then values: finite numbers, counts, string lengths, UTF-8, no control characters in
  // names. The error says which field is wrong; it is the peer's fault, never ours. Views in the message are
  // valid until the next call.
  //
  // A StreamDescription or Welcome of another protocol major holds only the fields that all majors share
  // (versions, epoch, and the adapter's name or the status): the caller compares protocol_major and answers
  // version_mismatch.
  Result<Message> decode(std::span<const std::byte> bytes);

  // Of the message before, when it was an image request that holds what is not allowed.
  const std::optional<ImageRequestName>& refused_request() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fire3dv::wire
