// protocol/schema/fire3dv.fbs as flatc compiles it (a reflection.Schema buffer), so that whoever opens a
// recording can read its messages without this project.
#pragma once

#include <cstddef>
#include <span>

namespace fire3dv::record {

std::span<const std::byte> message_schema();

}  // namespace fire3dv::record
