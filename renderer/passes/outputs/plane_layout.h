// Memory layout of output planes: one plane after the other, in the order of the output bits.
//
// With four samples, the primitive instance with most samples of a pixel wins. Ties select the nearest one
// with a triangle over the centre, then the background, then the first sample. Depth is that at the centre,
// or the mean over the instance's samples if none of its triangles covers the centre. Motion excludes mesh
// deformation.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "protocol/wire/image_outputs.h"

namespace fire3dv::passes {

using wire::ImageOutput;
using wire::ImageOutputs;
using wire::with_sources;

struct PlaneRange {
  ImageOutput output;
  uint64_t offset_bytes;
  uint64_t size_bytes;
};
// Colours for displays are an image and boxes are made on the CPU: both have no plane.
std::vector<PlaneRange> lay_out_planes(const ImageOutputs& outputs, uint32_t width, uint32_t height);
uint64_t bytes_of(std::span<const PlaneRange> places);

}  // namespace fire3dv::passes
