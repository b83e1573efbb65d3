// Instances in captured images: bounding boxes of the visible ones, and the list of their names.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "protocol/wire/image_outputs.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::capture {

// Sorted by instance.
struct VisibleBoxes {
  std::vector<wire::BoxRecord2d> boxes2d;
  std::vector<wire::BoxRecord3d> boxes3d;
};
// instance_plane: kInstanceU32 in rows of `width` pixels, at any alignment. known: boxes of all instances at
// the image's poses.
VisibleBoxes find_visible_boxes(std::span<const uint8_t> instance_plane, uint32_t width,
                                std::span<const wire::BoxRecord3d> known);

// One line of JSON per node with a mesh: instance, class, name and path.
std::string list_instances(const scene::Scene& scene);

}  // namespace fire3dv::capture
