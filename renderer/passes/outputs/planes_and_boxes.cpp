#include "renderer/passes/outputs/planes_and_boxes.h"

#include <algorithm>
#include <map>

#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/model/bounds.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {
namespace {

constexpr uint64_t kPlaneAlignment = 64;

scene::Box bounds_of_mesh(const scene::Scene& scene, const scene::Mesh& mesh) {
  scene::Box box;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    if (scene.primitives[p].index_count > 0)
      box.add(scene::Box{scene.primitives[p].bounds_min, scene.primitives[p].bounds_max});
  }
  return box;
}

std::array<float, 12> box_rows(const glm::mat4& m) {
  std::array<float, 12> rows{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) rows[static_cast<size_t>(4 * row + column)] = m[column][row];
  }
  return rows;
}

// Transform from the unit cube around the origin.
glm::mat4 from_cube(const scene::Box& box) {
  glm::mat4 m(1);
  for (int axis = 0; axis < 3; ++axis) m[axis][axis] = box.high[axis] - box.low[axis];
  m[3] = glm::vec4(0.5f * (box.low + box.high), 1);
  return m;
}

// Returns null if the list lacks this instance.
const wire::BoxRecord3d* find(std::span<const wire::BoxRecord3d> known, uint32_t instance) {
  const auto at =
      std::lower_bound(known.begin(), known.end(), instance,
                       [](const wire::BoxRecord3d& box, uint32_t wanted) { return box.instance < wanted; });
  return at != known.end() && at->instance == instance ? &*at : nullptr;
}

void add_run(wire::BoxRecord2d& box, uint32_t first_x, uint32_t end_x, uint32_t y) {
  const bool is_first = box.pixels == 0;
  box.min_x = is_first ? first_x : std::min(box.min_x, first_x);
  box.max_x = std::max(box.max_x, end_x);
  if (is_first) box.min_y = y;
  box.max_y = y + 1;
  box.pixels += end_x - first_x;
}

}  // namespace
std::vector<PlaneRange> lay_out_planes(const ImageOutputs& outputs, uint32_t width, uint32_t height) {
  std::vector<PlaneRange> places;
  uint64_t offset = 0;
  for (const wire::ImageOutputInfo& info : wire::kImageOutputTable) {
    if (!outputs.has(info.output) || info.output == wire::kColorSrgb8 || info.is_boxes) continue;
    const uint64_t size = uint64_t{info.element_bytes} * width * height;
    places.push_back({info.output, offset, size});
    offset = (offset + size + kPlaneAlignment - 1) / kPlaneAlignment * kPlaneAlignment;
  }
  return places;
}

uint64_t bytes_of(std::span<const PlaneRange> places) {
  return places.empty() ? 0 : places.back().offset_bytes + places.back().size_bytes;
}

std::vector<wire::BoxRecord3d> boxes_of_instances(const scene::Scene& scene, const state::PoseState& poses) {
  std::vector<glm::mat4> world_from_node(scene.nodes.size());
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) world_from_node[n] = poses.world_from_node(n);
  std::vector<wire::BoxRecord3d> boxes;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    const scene::Node& node = scene.nodes[n];
    if (node.mesh == scene::kNone) continue;
    const bool deformed = scene::is_deformed(node);
    const scene::Box box = deformed ? scene::bounds_in_world(scene, n, world_from_node)
                                    : bounds_of_mesh(scene, scene.meshes[node.mesh]);
    if (box.empty()) continue;
    const glm::mat4 world_from_box = deformed ? from_cube(box) : world_from_node[n] * from_cube(box);
    boxes.push_back({n + 1, node.semantic, box_rows(world_from_box), {}});
  }
  return boxes;
}

std::vector<wire::BoxRecord2d> boxes_in_image(std::span<const uint32_t> instances, uint32_t width,
                                              std::span<const wire::BoxRecord3d> known) {
  std::map<uint32_t, wire::BoxRecord2d> boxes;
  for (uint32_t y = 0; width > 0 && y < instances.size() / width; ++y) {
    const std::span<const uint32_t> row = instances.subspan(size_t{y} * width, width);
    // Runs of equal ids: neighbouring pixels mostly show the same instance.
    for (uint32_t x = 0; x < width;) {
      uint32_t end = x + 1;
      while (end < width && row[end] == row[x]) ++end;
      if (row[x] != 0) add_run(boxes[row[x]], x, end, y);
      x = end;
    }
  }
  std::vector<wire::BoxRecord2d> found;
  found.reserve(boxes.size());
  for (auto& [instance, box] : boxes) {
    const wire::BoxRecord3d* const labelled = find(known, instance);
    box.instance = instance;
    box.semantic = labelled ? labelled->semantic : 0;
    found.push_back(box);
  }
  return found;
}

std::vector<wire::BoxRecord3d> seen_boxes(std::span<const wire::BoxRecord3d> known,
                                          std::span<const wire::BoxRecord2d> seen) {
  std::vector<wire::BoxRecord3d> boxes;
  for (const wire::BoxRecord2d& box : seen) {
    if (const wire::BoxRecord3d* const of_instance = find(known, box.instance)) boxes.push_back(*of_instance);
  }
  return boxes;
}

}  // namespace fire3dv::passes
