// The part of the decoder that reads scene edits; private to protocol/wire.
#pragma once

#include "protocol/error.h"
#include "protocol/wire/decode.h"

namespace fire3dv::wire::fbs {
struct SceneEdit;
}

namespace fire3dv::wire {

// `table` lies in a buffer that the verifier has passed.
Result<Message> read_scene_edit(const fbs::SceneEdit& table, const DecodeLimits& limits);

}  // namespace fire3dv::wire
