// The part of the decoder that reads what is about images; private to protocol/wire.
#pragma once

#include "protocol/error.h"
#include "protocol/wire/decode.h"

namespace fire3dv::wire::fbs {
struct ImageRequest;
struct ImageFrame;
struct ImageRefused;
}  // namespace fire3dv::wire::fbs

namespace fire3dv::wire {

// The tables lie in a buffer that the verifier has passed.
Result<Message> read_image_request(const fbs::ImageRequest& table, const DecodeLimits& limits);
Result<Message> read_image_frame(const fbs::ImageFrame& table, const DecodeLimits& limits);
Result<Message> read_image_refused(const fbs::ImageRefused& table, const DecodeLimits& limits);

}  // namespace fire3dv::wire
