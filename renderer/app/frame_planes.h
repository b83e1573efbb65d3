// The planes of an image on their way from the GPU to a sink, and the boxes that are found in them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/passes/boxes.h"
#include "renderer/passes/image_outputs.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::app {

// What of them is known when the image is taken.
struct TakenPlanes {
  std::vector<passes::PlanePlace> places;
  std::vector<passes::Box3d> boxes;  // of all instances, where boxes are wanted
};

TakenPlanes take_planes(const passes::ImageOutputs& wanted, const std::vector<passes::PlanePlace>& places,
                        const scene::Scene& scene, const state::PoseState& poses);

// bytes: of the planes, as they were placed. Those that are wanted go into the image, with its boxes.
void add_planes(const passes::ImageOutputs& wanted, const TakenPlanes& taken, std::span<const uint8_t> bytes,
                sinks::FrameImage& image);

// One line of JSON for each node that shows something: its instance, class, name and path.
std::string instance_list(const scene::Scene& scene);

}  // namespace fire3dv::app
