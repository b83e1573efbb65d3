#include "renderer/capture/instances.h"

#include <cstring>

#include "renderer/passes/visibility/boxes.h"
#include "renderer/sinks/text.h"

namespace fire3dv::capture {

VisibleBoxes find_visible_boxes(std::span<const uint8_t> instance_plane, uint32_t width,
                                std::span<const wire::BoxRecord3d> known) {
  std::vector<uint32_t> instances(instance_plane.size() / sizeof(uint32_t));
  if (!instances.empty())
    std::memcpy(instances.data(), instance_plane.data(), instances.size() * sizeof(uint32_t));
  VisibleBoxes boxes;
  boxes.boxes2d = passes::boxes_in_image(instances, width, known);
  boxes.boxes3d = passes::seen_boxes(known, boxes.boxes2d);
  return boxes;
}

std::string list_instances(const scene::Scene& scene) {
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

}  // namespace fire3dv::capture
