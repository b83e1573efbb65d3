// Last step of each encoder; private to protocol/wire.
#pragma once

#include "fire3dv_generated.h"
#include "protocol/wire/encode.h"

namespace fire3dv::wire {

inline Bytes finish(flatbuffers::FlatBufferBuilder& builder, fbs::Body type, flatbuffers::Offset<void> body) {
  fbs::MessageBuilder message(builder);
  message.add_body(body);
  message.add_body_type(type);
  builder.Finish(message.Finish(), fbs::MessageIdentifier());
  const auto* begin = reinterpret_cast<const std::byte*>(builder.GetBufferPointer());
  return Bytes(begin, begin + builder.GetSize());
}

}  // namespace fire3dv::wire
