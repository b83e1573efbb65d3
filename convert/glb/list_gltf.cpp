#include "convert/glb/list_gltf.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "base/files.h"
#include "renderer/scene/gltf/load_gltf.h"

namespace fire3dv::convert {
namespace {

uint64_t triangles_of(const scene::Scene& scene, const scene::Mesh& mesh) {
  uint64_t triangles = 0;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    if (scene.primitives[p].topology == scene::Topology::triangles)
      triangles += scene.primitives[p].index_count / 3;
  }
  return triangles;
}

}  // namespace

bool is_gltf_name(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".glb" || extension == ".gltf";
}

Result<std::vector<std::string>> list_gltf(const std::filesystem::path& file,
                                           std::vector<std::string>& warnings) {
  constexpr size_t kMaxIndent = 64;  // levels: a chain of nodes would print quadratically many spaces
  const Result<scene::Scene> scene = scene::load_gltf(file);
  if (!scene) return scene.error();
  warnings.insert(warnings.end(), scene->warnings.begin(), scene->warnings.end());
  std::vector<std::string> lines;
  std::vector<size_t> depths;
  for (const scene::Node& node : scene->nodes) {
    depths.push_back(node.parent == scene::kNone ? 0 : depths[node.parent] + 1);
    std::string line = std::string(2 * std::min(depths.back(), kMaxIndent), ' ');
    line += node.name.empty() ? "-" : node.name;
    if (node.mesh != scene::kNone)
      line += "\t" + std::to_string(triangles_of(*scene, scene->meshes[node.mesh])) + " triangles";
    if (node.camera != scene::kNone) line += "\tcamera";
    if (node.light != scene::kNone) line += "\tlight";
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace fire3dv::convert
