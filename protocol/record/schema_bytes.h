// Compiled FlatBuffers schemas (reflection.Schema buffers), embedded in recordings for readers without this
// project.
#pragma once

#include <cstddef>
#include <span>

namespace fire3dv::record {

std::span<const std::byte> message_schema();       // protocol/schema/fire3dv.fbs
std::span<const std::byte> transforms_schema();    // protocol/schema/foxglove/frame_transforms.fbs
std::span<const std::byte> scene_update_schema();  // protocol/schema/foxglove/scene_update.fbs

}  // namespace fire3dv::record
