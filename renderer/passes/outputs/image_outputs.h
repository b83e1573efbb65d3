// Image outputs: colour for displays, and planes of numbers. All come from one visibility buffer of one
// camera, so they agree in each pixel.
//
// Planes show the surface at the pixel's centre without filtering; blended surfaces, lines and points appear
// in colours only. With four samples, the primitive instance with most samples wins. Ties select the nearest
// one with a triangle over the centre, then the background, then the first sample. Depth is that at the
// centre, or the mean over the instance's samples if none of its triangles covers the centre.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"

namespace fire3dv::passes {

enum class Plane : uint8_t {
  color_linear_f16,  // linear RGB before exposure and tone mapping, and 1, as half floats
  depth_f32,         // metres along the camera's axis; infinite for the background
  instance_u32,      // node index + 1; 0: background
  semantic_u32,      // node class, see scene::Node::semantic; 0: none or background
  // World-space unit normal without normal maps, on the visible side, and 0; all 0 for the background.
  normal_f16,
  // Pixels right and down since the camera's last image; 0 in its first, NaN where the surface was behind the
  // eye. Excludes mesh deformation.
  motion_f32,
};
constexpr size_t kPlaneCount = 6;

struct PlaneFormat {
  std::string_view name;  // in file names and on the command line
  std::string_view type;  // NumPy type of a number; little-endian
  uint32_t channels;      // numbers per pixel
  uint32_t pixel_bytes;
};
const PlaneFormat& format_of(Plane plane);

struct ImageOutputs {
  bool color_srgb8 = true;  // false: nothing is shaded
  std::array<bool, kPlaneCount> planes{};
  bool boxes2d = false;  // of visible instances; needs the instance plane
  bool boxes3d = false;

  bool& operator[](Plane plane) { return planes[static_cast<size_t>(plane)]; }
  bool operator[](Plane plane) const { return planes[static_cast<size_t>(plane)]; }
  bool any_plane() const;
  // True if an output depends on ids and depths.
  bool any_surface_plane() const;
  bool shaded() const { return color_srgb8 || (*this)[Plane::color_linear_f16]; }
  bool operator==(const ImageOutputs&) const = default;
};

// Adds the sources of requested outputs: 2D boxes need the instance plane.
ImageOutputs with_sources(ImageOutputs outputs);

// Parses "color,depth,instance": each name at most once.
Result<ImageOutputs> parse_image_outputs(std::string_view text);

// Planes in memory, in sequence.
struct PlanePlace {
  Plane plane;
  uint64_t offset_bytes;
  uint64_t size_bytes;
};
std::vector<PlanePlace> place_planes(const ImageOutputs& outputs, uint32_t width, uint32_t height);
uint64_t bytes_of(std::span<const PlanePlace> places);

}  // namespace fire3dv::passes
