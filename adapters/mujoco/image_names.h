// Names of image outputs and cameras on command lines and in file names.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "adapters/mujoco/publisher.h"
#include "protocol/base/error.h"

namespace fire3dv::mujoco {

// Parses "color,depth" to FIRE3DV_IMAGE_* bits. The error lists valid names.
Result<uint32_t> image_outputs(std::string_view text);

// Parses "CAMERA" or "CAMERA:320x240". Camera names may contain colons.
Result<ImageSpec> image_spec(const std::string& text);

}  // namespace fire3dv::mujoco
