// Check of an image against its request. Renderers are not trusted: a program copies the size that it has
// requested.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/error.h"
#include "protocol/wire/image.h"

namespace fire3dv::client {

// frame: decoded, and checked in itself; its planes lie in `pixels`. newest_sequence: the last published
// frame. The error says what differs, one clause that follows "an image was dropped: ".
Result<void> check_answer(const wire::ImageFrame& frame, std::span<const std::byte> pixels,
                          const wire::ImageRequest& request, uint64_t newest_sequence);

}  // namespace fire3dv::client
