// Parts of Foxglove's messages that several encoders share. Private to foxglove*.cpp: it includes the code
// that flatc generates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "geometry_generated.h"
#include "protocol/wire/affine.h"

namespace fire3dv::record {

foxglove::Time time_of(uint64_t unix_ns);

// Writes defaults explicitly: the defaults differ between versions of the schemas.
flatbuffers::FlatBufferBuilder builder_that_writes_all(size_t bytes);

// Valid until the builder changes.
std::span<const std::byte> bytes_of(const flatbuffers::FlatBufferBuilder& builder);

// Rotates a transform by 90 degrees about X: from Y up to Z up.
wire::Affine3x4d z_up_from(const wire::Affine3x4d& y_up_from_stream);

}  // namespace fire3dv::record
