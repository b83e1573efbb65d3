// Decoder: bytes to messages. FlatBuffers verification happens only in decode.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "base/error.h"
#include "protocol/wire/limits.h"
#include "protocol/wire/messages.h"

namespace fire3dv::wire {

// Limits for received messages. The defaults suit a renderer; tests lower them.
struct DecodeLimits {
  size_t max_message_bytes = kMaxMessageBytes;
  uint32_t max_nodes = 1u << 20;
  uint32_t max_name_bytes = 1024;  // names of nodes, adapters and renderers
  uint32_t max_text_bytes = 4096;  // URIs and user messages
  // Magnitude of a pose element; larger ones are rejected, like NaN and infinity.
  float max_abs_value = 1e12f;
};

// Identity of an image request, for a refusal.
struct ImageRequestName {
  uint64_t epoch = 0, id = 0;
};

// Decoder of messages, with an aligned copy of their bytes for decode(). One decoder per thread; reuses the
// copy's memory.
class Decoder {
 public:
  explicit Decoder(DecodeLimits limits = {});
  ~Decoder();
  Decoder(Decoder&&) noexcept;
  Decoder& operator=(Decoder&&) noexcept;

  // Validates the structure, then the values: finite numbers, counts, string lengths, UTF-8, no control
  // characters in names. The error names the invalid field; the fault is always the peer's. Views in the
  // message are valid until the next call.
  //
  // A StreamDescription or Welcome of another protocol major contains only the fields shared by all majors
  // (versions, epoch, and adapter name or status). The caller compares protocol_major and answers
  // version_mismatch.
  Result<Message> decode(std::span<const std::byte> bytes);
  // Same without the copy if `bytes` are aligned to 16 bytes. They must be private memory, which no other
  // process or thread writes, and must not change while views in the message are in use.
  Result<Message> decode_in_place(std::span<const std::byte> bytes);

  // Set if the last message was an image request with invalid values.
  const std::optional<ImageRequestName>& refused_request() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fire3dv::wire
