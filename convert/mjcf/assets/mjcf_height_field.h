// Height field assets of MJCF.
#pragma once

#include "base/error.h"
#include "convert/mjcf/scene/mjcf_scene.h"
#include "convert/mjcf/xml/mjcf_element.h"

namespace fire3dv::convert {

class MjcfSource;

// Reads PNG, MuJoCo's binary format or inline elevations, at most 2^24 of them. The error is a sentence end
// about the asset.
Result<MjcfHeightField> read_mjcf_height_field(MjcfSource& source, const MjcfElement& element);

}  // namespace fire3dv::convert
