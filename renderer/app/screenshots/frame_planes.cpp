#include "renderer/app/screenshots/frame_planes.h"

#include <cstring>

#include "renderer/sinks/text.h"

namespace fire3dv::app {
namespace {

std::vector<uint32_t> numbers_of(std::span<const uint8_t> bytes) {
  std::vector<uint32_t> numbers(bytes.size() / sizeof(uint32_t));
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(uint32_t));
  return numbers;
}

void add_boxes(const passes::ImageOutputs& wanted, const ReadbackPlanes& taken,
               std::span<const uint8_t> instances, sinks::FrameImage& image) {
  const std::vector<passes::Box2d> seen =
      passes::boxes_in_image(numbers_of(instances), image.width, taken.boxes);
  if (wanted.boxes2d) {
    image.boxes2d.emplace();
    for (const passes::Box2d& b : seen)
      image.boxes2d->push_back({b.instance, b.semantic, b.min_x, b.min_y, b.max_x, b.max_y, b.pixels});
  }
  if (wanted.boxes3d) {
    image.boxes3d.emplace();
    for (const passes::Box3d& b : passes::seen_boxes(taken.boxes, seen))
      image.boxes3d->push_back({b.instance, b.semantic, b.world_from_box});
  }
}

}  // namespace

ReadbackPlanes collect_planes(const passes::ImageOutputs& wanted,
                              const std::vector<passes::PlanePlace>& places, const scene::Scene& scene,
                              const state::PoseState& poses) {
  ReadbackPlanes taken{places, {}};
  if (wanted.boxes2d || wanted.boxes3d) taken.boxes = passes::boxes_of_instances(scene, poses);
  return taken;
}

void add_planes(const passes::ImageOutputs& wanted, const ReadbackPlanes& taken,
                std::span<const uint8_t> bytes, sinks::FrameImage& image) {
  for (const passes::PlanePlace& place : taken.places) {
    const std::span<const uint8_t> plane = bytes.subspan(place.offset_bytes, place.size_bytes);
    if (place.plane == passes::Plane::instance_u32 && (wanted.boxes2d || wanted.boxes3d))
      add_boxes(wanted, taken, plane, image);
    if (!wanted[place.plane]) continue;
    const passes::PlaneFormat& format = passes::format_of(place.plane);
    image.planes.push_back({std::string(format.name), std::string(format.type), format.channels,
                            std::vector<uint8_t>(plane.begin(), plane.end())});
  }
}

std::string instance_list(const scene::Scene& scene) {
  std::string text;
  for (size_t n = 0; n < scene.nodes.size(); ++n) {
    const scene::Node& node = scene.nodes[n];
    if (node.mesh == scene::kNone) continue;
    text += "{\"instance\":" + std::to_string(n + 1) + ",\"semantic\":" + std::to_string(node.semantic) +
            ",\"name\":" + sinks::json_string(node.name) + ",\"path\":" + sinks::json_string(node.path) +
            "}\n";
  }
  return text;
}

}  // namespace fire3dv::app
