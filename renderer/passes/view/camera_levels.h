// Choice of the levels of detail of a camera (shaders/visibility/level_choice.glsl).
#pragma once

#include <cstdint>

namespace fire3dv::passes {

enum class CameraLevels : uint8_t {
  finest,         // the file's own triangles
  by_appearance,  // normals, colours and texture coordinates count
  by_surface,     // the distance of surfaces alone; masked surfaces by appearance
};

}  // namespace fire3dv::passes
