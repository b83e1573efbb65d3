#include "renderer/capture/capture.h"

#include <cstring>
#include <utility>

#include "renderer/passes/outputs/silhouettes.h"
#include "renderer/passes/path/path_pass.h"
#include "renderer/sinks/output_text.h"

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

std::optional<sinks::PathTraced> path_provenance(const passes::SceneRenderer& renderer) {
  const passes::PathPass* const paths = renderer.path_tracer();
  if (!paths) return std::nullopt;
  return sinks::PathTraced{paths->shown_samples(), paths->settings().bounces, paths->settings().seed};
}

void CaptureQueue::record(gpu::Recorder& recorder, gpu::Image& color, Provenance provenance) {
  readback_.record(recorder, color, {{}, {}, {}, {}, std::move(provenance)});
}

void CaptureQueue::record(gpu::Recorder& recorder, passes::SceneRenderer& renderer,
                          wire::ImageOutputs outputs, const scene::Scene& scene,
                          const state::PoseState& poses, Provenance provenance) {
  Capture capture{outputs, {}, {}, {}, std::move(provenance)};
  gpu::ReadbackRing<Capture>::Planes planes;
  if (wire::with_sources(outputs).has_planes()) {
    capture.plane_ranges = renderer.plane_ranges();
    planes = {&renderer.planes(), passes::bytes_of(capture.plane_ranges)};
  }
  if (outputs.has_boxes()) capture.boxes = passes::boxes_of_instances(scene, poses);
  if (outputs.has(wire::kAmodal)) {
    for (const uint32_t node : passes::nodes_with_silhouettes(scene))
      capture.silhouetted.push_back({node + 1, scene.nodes[node].semantic});
  }
  gpu::Image* const color = outputs.has(wire::kColorSrgb8) ? &renderer.image() : nullptr;
  readback_.record(recorder, color, renderer.extent(), planes, std::move(capture));
}

void CaptureQueue::poll(const std::function<void(sinks::FrameImage&&)>& take) {
  readback_.poll([&](Capture capture, VkExtent2D extent, std::span<const uint8_t> bytes) {
    take(convert(std::move(capture), extent, bytes));
  });
}

Result<void> CaptureQueue::deliver(sinks::FrameSink& sink) {
  Result<void> result;
  readback_.poll([&](Capture capture, VkExtent2D extent, std::span<const uint8_t> bytes) {
    if (result) result = sink.consume(convert(std::move(capture), extent, bytes));
  });
  return result;
}

sinks::FrameImage CaptureQueue::convert(Capture&& capture, VkExtent2D extent,
                                        std::span<const uint8_t> bytes) {
  sinks::FrameImage image;
  image.width = extent.width;
  image.height = extent.height;
  image.frame_index = capture.provenance.frame_index;
  image.camera = std::move(capture.provenance.camera);
  image.shown = std::move(capture.provenance.shown);
  image.path_traced = capture.provenance.path_traced;
  image.hidden_streams = std::move(capture.provenance.hidden_streams);
  image.run_provenance = std::move(capture.provenance.run);
  const wire::ImageOutputs outputs = capture.outputs;
  const size_t color_bytes =
      outputs.has(wire::kColorSrgb8) ? size_t{4} * extent.width * extent.height : size_t{0};
  image.rgba8.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(color_bytes));
  std::span<const uint8_t> instances;
  for (const passes::PlaneRange& range : capture.plane_ranges) {
    const std::span<const uint8_t> plane = bytes.subspan(color_bytes + range.offset_bytes, range.size_bytes);
    if (range.output == wire::kInstanceU32) instances = plane;
    if (range.output == wire::kAmodal) {
      image.amodal = read_silhouettes(plane, instances, extent.width, extent.height, capture.silhouetted);
      continue;
    }
    if (outputs.has(range.output))
      image.planes.push_back({range.output, std::vector<uint8_t>(plane.begin(), plane.end())});
    if (range.output != wire::kInstanceU32 || !outputs.has_boxes()) continue;
    VisibleBoxes boxes = find_visible_boxes(plane, extent.width, capture.boxes);
    if (outputs.has(wire::kBoxes2d)) image.boxes2d = std::move(boxes.boxes2d);
    if (outputs.has(wire::kBoxes3d)) image.boxes3d = std::move(boxes.boxes3d);
  }
  return image;
}

}  // namespace fire3dv::capture
