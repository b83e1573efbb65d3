// Basic types of the structures that C++ and GLSL share. The layout is scalar, like that of C++; a test
// compares the offsets with the compiled shaders' reflection. 64-bit members come first or are aligned to 8
// bytes.
#ifndef FIRE3DV_SHARED_BASICS_H
#define FIRE3DV_SHARED_BASICS_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/glm.hpp>
#define FIRE3DV_SHARED_BEGIN namespace fire3dv::gpu_types {
#define FIRE3DV_SHARED_END }
#define FIRE3DV_ADDRESS uint64_t
#else
#define FIRE3DV_SHARED_BEGIN
#define FIRE3DV_SHARED_END
#define FIRE3DV_ADDRESS uint64_t
#endif

#define FIRE3DV_NO_INDEX 0xffffffffu

FIRE3DV_SHARED_BEGIN
#ifdef __cplusplus
using glm::ivec2;
using glm::mat4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using uint = uint32_t;
#endif

// A 3x4 affine matrix in row-major order: the layout of Affine3x4 on the wire and of VkTransformMatrixKHR.
struct AffineRows {
  vec4 row0;
  vec4 row1;
  vec4 row2;
};
FIRE3DV_SHARED_END
#endif
