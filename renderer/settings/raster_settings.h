// Draw settings of the raster: path, culling and levels of detail.
#pragma once

#include <cstdint>

namespace fire3dv::settings {

enum class RasterPath : uint8_t {
  automatic,   // visibility where the device supports it, otherwise forward
  forward,     // the raster pipeline: the reference
  visibility,  // compute, from a visibility buffer
};

// Use of coarser LODs on the visibility path.
enum class LevelsOfDetail : uint8_t {
  off,
  camera,
  surface,     // the camera's, by the distance of surfaces alone, not by normals, colours and texture
               // coordinates
  everywhere,  // also in shadow maps: a quarter of a texel around a shadow's edge may then be lit
  automatic,   // the camera's, in scenes where they pay
};

// Culling level. All levels yield the same image.
enum class Cull : uint8_t {
  off,
  view,       // frustum, back-face and small-primitive culling
  hidden,     // also occlusion culling
  automatic,  // occlusion culling in large scenes while it pays
};

// Images in motion of windows and browsers.
enum class MotionQuality : uint8_t {
  automatic,  // on a CPU: see settings_in_motion()
  full,       // as at rest
};

}  // namespace fire3dv::settings
