// Image planes between GPU read-back and sink, and the bounding boxes computed from them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/passes/outputs/image_outputs.h"
#include "renderer/passes/visibility/boxes.h"
#include "renderer/sinks/frame.h"

namespace fire3dv::app {

// State of the planes at the time of rendering.
struct ReadbackPlanes {
  std::vector<passes::PlanePlace> places;
  std::vector<passes::Box3d> boxes;  // of all instances, if boxes are requested
};

ReadbackPlanes collect_planes(const passes::ImageOutputs& wanted,
                              const std::vector<passes::PlanePlace>& places, const scene::Scene& scene,
                              const state::PoseState& poses);

// Adds the requested planes, with boxes, to the image. bytes: read-back of the planes, laid out as in
// `taken`.
void add_planes(const passes::ImageOutputs& wanted, const ReadbackPlanes& taken,
                std::span<const uint8_t> bytes, sinks::FrameImage& image);

// One line of JSON per visible node: instance, class, name and path.
std::string instance_list(const scene::Scene& scene);

}  // namespace fire3dv::app
