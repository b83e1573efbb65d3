// What an image consists of: a colour for displays, and planes of numbers beside it, all of one camera from
// one visibility buffer, so that they agree in each pixel.
//
// Planes show the surface in the pixel's middle and are never smoothed. Of four samples a pixel none lies in the
// middle: what most of them show is taken, where a surface is all that one part shows (a primitive at a node); of
// equally many the nearest of which a triangle covers the middle, else the background, else the first sample's.
// Its depth is that in the pixel's middle; where others have a share of the pixel and no triangle of its covers the
// middle, in the middle of its samples. What is blended or drawn as lines and points shows in colours alone.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::passes {

enum class Plane : uint8_t {
  color_linear_f16,  // red, green, blue and 1: light before exposure and tone mapping, as half floats
  depth_f32,         // metres along the axis of the camera; infinite for the background
  instance_u32,      // node's index in the scene plus one; 0 = background
  semantic_u32,      // class of the node, see scene::Node::semantic; 0 = none or background
  normal_f16,  // of the surface in the world, unit, without normal maps, on the seen side, and a 0; 0 for the
               // background
  motion_f32,  // pixels to the right and down from where the surface was in the camera's last image; 0 in its
               // first, not a number where that was behind the eye. What deforms a mesh is left out
};
constexpr size_t kPlaneCount = 6;

struct PlaneFormat {
  std::string_view name;  // as on the command line and in files' names
  std::string_view type;  // of a number, as NumPy writes it; little-endian
  uint32_t channels;      // numbers a pixel
  uint32_t pixel_bytes;
};
const PlaneFormat& format_of(Plane plane);

struct ImageOutputs {
  bool color_srgb8 = true;  // without colours nothing is shaded
  std::array<bool, kPlaneCount> planes{};
  bool boxes2d = false;  // around what the image shows of each instance: needs the plane of instances
  bool boxes3d = false;

  bool& operator[](Plane plane) { return planes[static_cast<size_t>(plane)]; }
  bool operator[](Plane plane) const { return planes[static_cast<size_t>(plane)]; }
  bool any_plane() const;
  // Any that comes from ids and depths.
  bool any_surface_plane() const;
  bool shaded() const { return color_srgb8 || (*this)[Plane::color_linear_f16]; }
  bool operator==(const ImageOutputs&) const = default;
};

// With what these are made of: boxes are found in the plane of instances.
ImageOutputs with_sources(ImageOutputs outputs);

// "color,depth,instance": each name once at most.
Result<ImageOutputs> parse_image_outputs(std::string_view text);

// Where planes lie in memory, one after the other in their order.
struct PlanePlace {
  Plane plane;
  uint64_t offset_bytes;
  uint64_t size_bytes;
};
std::vector<PlanePlace> place_planes(const ImageOutputs& outputs, uint32_t width, uint32_t height);
uint64_t bytes_of(std::span<const PlanePlace> places);

}  // namespace fire3dv::passes
