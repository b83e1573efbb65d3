// Foxglove's FrameTransform and FrameTransforms, in Protocol Buffers and in JSON.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/error.h"
#include "protocol/import/messages/messages.h"

namespace fire3dv::imported {

// many: the message is a FrameTransforms.
Result<void> decode_protobuf_transforms(std::span<const std::byte> message, bool many,
                                        std::vector<TransformSample>& samples);
Result<void> decode_json_transforms(std::span<const std::byte> message, bool many,
                                    std::vector<TransformSample>& samples);

}  // namespace fire3dv::imported
