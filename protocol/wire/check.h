// Validation of message values, shared by the decoder (received messages) and the client library (messages to
// send), so that both report the same error. Each error begins with the field's name.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/messages.h"

namespace fire3dv::wire {

Result<void> check(const StreamDescription& description, const DecodeLimits& limits);
Result<void> check(const Status& status, const DecodeLimits& limits);
Result<void> check(const PoseFrameView& frame, const DecodeLimits& limits);
Result<void> check(const Welcome& welcome, const DecodeLimits& limits);
Result<void> check(const SceneEdit& edit, const DecodeLimits& limits);
Result<void> check(const Scalars& scalars, const DecodeLimits& limits);
Result<void> check(const ScalarValues& scalars);
Result<void> check(const Input& input);
Result<void> check(const InputEvent& event, const DecodeLimits& limits);
Result<void> check(const ImageRequest& request, const DecodeLimits& limits);
Result<void> check(const ImageFrame& frame, const DecodeLimits& limits);
Result<void> check(const ImageRefused& refused, const DecodeLimits& limits);

// Requires names that differ; the error names the first repeated one.
Result<void> check_unique(std::string_view field, const std::vector<std::string>& names);

// Valid UTF-8 (shortest form, no surrogates) of at most max_bytes, without characters that move a terminal's
// cursor or break a line: names appear in logs and on consoles.
Result<void> check_text(std::string_view field, std::string_view text, size_t max_bytes);

// Requires finite elements of at most `limit` in magnitude; the error names the first invalid one.
Result<void> check_poses(std::string_view field, std::span<const Affine3x4> poses, float limit);

// Converts arbitrary bytes to text that check_text() accepts: invalid characters become '?', and the text is
// truncated at a character boundary. For messages that quote a peer or a caller.
std::string printable(std::string_view text, size_t max_bytes = 96);

}  // namespace fire3dv::wire
