// Number of fields of an encoded protobuf message, to refuse messages that would take far more memory decoded
// than encoded: an empty message of 2 bytes becomes an object of 100 and more.
#pragma once

#include <cstddef>
#include <span>

namespace fire3dv::gazebo {

// True if the message and all that may be messages within it have at most `most` fields together. A text that
// reads as a message is counted as one. Time: proportional to the bytes, for each of the 12 levels that are
// read. False for bytes that are no message.
bool has_at_most_fields(std::span<const std::byte> message, size_t most);

}  // namespace fire3dv::gazebo
