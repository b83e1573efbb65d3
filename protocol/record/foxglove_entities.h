// Encoding of single markers as Foxglove's scene entities and point clouds. Private to foxglove*.cpp.
#pragma once

#include <cstdint>
#include <string>

#include "protocol/wire/affine.h"
#include "protocol/wire/encode.h"
#include "protocol/wire/marker.h"

namespace fire3dv::record {

// Mean scale.
double scale_of(const wire::Affine3x4d& map);

// An upper bound of the encoded marker, of a known kind.
uint64_t max_bytes(const wire::Marker& marker);

// A SceneUpdate with the marker as its only entity. Points and images have no primitives.
wire::Bytes encode_entity(const wire::Marker& marker, const std::string& id, const std::string& frame_id,
                          const wire::Affine3x4d& frame_from_marker, uint64_t time_ns);

// A PointCloud of the positions: x y z as float32 relative to the pose, then red green blue alpha as uint8.
wire::Bytes encode_cloud(const wire::Marker& marker, const std::string& frame_id,
                         const wire::Affine3x4d& frame_from_marker, uint64_t time_ns);

}  // namespace fire3dv::record
