// Decoding of scene edits; private to protocol/wire.
#pragma once

#include "protocol/base/error.h"
#include "protocol/wire/decode.h"

namespace fire3dv::wire::fbs {
struct SceneEdit;
}

namespace fire3dv::wire {

// `table` must be in a verified buffer.
Result<Message> read_scene_edit(const fbs::SceneEdit& table, const DecodeLimits& limits);

}  // namespace fire3dv::wire
