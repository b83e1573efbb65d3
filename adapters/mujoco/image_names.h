// Names of image outputs and cameras on command lines and in file names.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "adapters/mujoco/publisher.h"
#include "protocol/base/error.h"

namespace fire3dv::mujoco {

// Numeric image plane; boxes and sRGB colours have no entry.
struct PlaneName {
  uint32_t output;  // FIRE3DV_IMAGE_* bit
  const char* name;
  const char* type;   // NumPy type of an element
  uint32_t channels;  // elements per pixel
  uint32_t pixel_bytes;
};
// Returns null for boxes and sRGB colours.
const PlaneName* plane_name(uint32_t output);

// Parses "color,depth" to FIRE3DV_IMAGE_* bits. The error lists valid names.
Result<uint32_t> image_outputs(std::string_view text);

// Parses "CAMERA" or "CAMERA:320x240". Camera names may contain colons.
Result<ImageSpec> image_spec(const std::string& text);

}  // namespace fire3dv::mujoco
