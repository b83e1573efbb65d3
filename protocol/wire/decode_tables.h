// Decoding of scene edits, image messages and input events; private to protocol/wire.
#pragma once

#include <cstddef>

#include "base/error.h"
#include "protocol/wire/decode.h"

namespace fire3dv::wire::fbs {
struct SceneEdit;
struct ImageRequest;
struct ImageFrame;
struct ImageRefused;
struct InputEvent;
}  // namespace fire3dv::wire::fbs

namespace fire3dv::wire {

// The tables must be in a verified buffer, of message_bytes.
Result<Message> read_scene_edit(const fbs::SceneEdit& table, size_t message_bytes,
                                const DecodeLimits& limits);
Result<Message> read_image_request(const fbs::ImageRequest& table, const DecodeLimits& limits);
Result<Message> read_image_frame(const fbs::ImageFrame& table, const DecodeLimits& limits);
Result<Message> read_image_refused(const fbs::ImageRefused& table, const DecodeLimits& limits);
Result<Message> read_input_event(const fbs::InputEvent& table, const DecodeLimits& limits);

}  // namespace fire3dv::wire
