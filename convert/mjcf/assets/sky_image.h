// Sky of six cube faces as one equirectangular image.
#pragma once

#include <array>

#include "convert/mjcf/assets/png_pixels.h"

namespace fire3dv::convert {

// Faces in the order right (+X), left, up (+Y), down, front (+Z), back of a cube map of OpenGL, whose axes
// are those of glTF for MuJoCo's skyboxes. An empty face is black.
using CubeFaces = std::array<PngPixels, 6>;

// At most 1024 rows, and twice as wide; narrow if is_even, where all columns are the same.
PngPixels sky_of(const CubeFaces& faces, bool is_even);

}  // namespace fire3dv::convert
