// Images as they are called on command lines and in files' names.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "adapters/mujoco/publisher.h"
#include "protocol/error.h"

namespace fire3dv::mujoco {

// A plane of numbers; boxes and colours for displays have none of these.
struct PlaneName {
  uint32_t output;  // FIRE3DV_IMAGE_* bit
  const char* name;
  const char* type;   // of a number, as NumPy writes it
  uint32_t channels;  // numbers a pixel
  uint32_t pixel_bytes;
};
// Null where the output is no such plane.
const PlaneName* plane_name(uint32_t output);

// "color,depth": FIRE3DV_IMAGE_* bits. The error names what there is.
Result<uint32_t> image_outputs(std::string_view text);

// "CAMERA" or "CAMERA:320x240". Names may hold colons themselves.
Result<ImageWish> image_wish(const std::string& text);

}  // namespace fire3dv::mujoco
