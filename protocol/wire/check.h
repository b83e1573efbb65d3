// Which values a message may hold, whichever way it goes: the decoder asks for what arrives, the client
// library for what is about to leave, so that both say the same sentence. Each error begins with the field's
// name.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "protocol/error.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/messages.h"

namespace fire3dv::wire {

Result<void> check(const StreamDescription& description, const DecodeLimits& limits);
Result<void> check(const Status& status, const DecodeLimits& limits);
Result<void> check(const PoseFrameView& frame, const DecodeLimits& limits);
Result<void> check(const Welcome& welcome, const DecodeLimits& limits);
Result<void> check(const SceneEdit& edit, const DecodeLimits& limits);
Result<void> check(const ImageRequest& request, const DecodeLimits& limits);
Result<void> check(const ImageFrame& frame, const DecodeLimits& limits);
Result<void> check(const ImageRefused& refused, const DecodeLimits& limits);

// Valid UTF-8 (shortest form, no surrogates) of at most max_bytes, without characters that would move a
// terminal's cursor or break a line: names end up in logs and on consoles.
Result<void> check_text(std::string_view field, std::string_view text, size_t max_bytes);

// All elements finite and at most limit in magnitude; the error names the first that is not.
Result<void> check_poses(std::string_view field, std::span<const Affine3x4> poses, float limit);

// Text that check_text would accept, made of any bytes: what may not be shown becomes '?', and the length is
// cut at a character. For sentences that quote what a peer or a caller gave.
std::string printable(std::string_view text, size_t max_bytes = 96);

}  // namespace fire3dv::wire
