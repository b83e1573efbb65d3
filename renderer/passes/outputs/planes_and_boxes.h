// Image outputs on the CPU: the memory layout of planes, and bounding boxes of instances.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "protocol/wire/image.h"
#include "protocol/wire/image_outputs.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::state {
class PoseState;
}

namespace fire3dv::passes {

using wire::ImageOutput;
using wire::ImageOutputs;
using wire::with_sources;

struct PlaneRange {
  ImageOutput output;
  uint64_t offset_bytes;
  uint64_t size_bytes;
};
// One plane after the other, in the order of the output bits. Colours for displays are an image and boxes are
// made on the CPU: both have no plane.
std::vector<PlaneRange> lay_out_planes(const ImageOutputs& outputs, uint32_t width, uint32_t height);
uint64_t bytes_of(std::span<const PlaneRange> places);

// Bounding boxes of instances: 2D boxes from the pixels that show them, and oriented 3D boxes in the world.
//
// Current boxes of all nodes with geometry, sorted by instance. Their axes are the node's for rigid meshes
// and the world's for skinned or morphed ones.
std::vector<wire::BoxRecord3d> boxes_of_instances(const scene::Scene& scene, const state::PoseState& poses);

// Boxes of the visible instances, sorted by instance. instances: one per pixel, top-down rows.
std::vector<wire::BoxRecord2d> boxes_in_image(std::span<const uint32_t> instances, uint32_t width,
                                              std::span<const wire::BoxRecord3d> known);

// Filters the known boxes by visibility in the image.
std::vector<wire::BoxRecord3d> seen_boxes(std::span<const wire::BoxRecord3d> known,
                                          std::span<const wire::BoxRecord2d> seen);

}  // namespace fire3dv::passes
