// Draw settings of the raster: path, culling and levels of detail, with their option names.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fire3dv::passes {

enum class RasterPath : uint8_t {
  automatic,   // visibility where the device supports it, otherwise forward
  forward,     // the raster pipeline: the reference
  visibility,  // compute, from a visibility buffer
};

// Use of coarser LODs on the visibility path.
enum class LevelsOfDetail : uint8_t {
  off,
  camera,
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

// Option names, shared by all programs.
inline const std::vector<std::string> kRasterPathNames{"auto", "forward", "visibility"};
inline const std::vector<std::string> kCullNames{"on", "off", "view", "hidden"};
inline const std::vector<std::string> kLevelsOfDetailNames{"auto", "on", "everywhere", "off"};

// name: one of those above; any other string selects the first.
RasterPath raster_path_named(const std::string& name);
Cull cull_named(const std::string& name);
LevelsOfDetail levels_of_detail_named(const std::string& name);

}  // namespace fire3dv::passes
