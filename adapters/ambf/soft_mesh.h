// A soft body's mesh as a glTF file of its own. Vertices that are streamed must be in the order of the
// file's, and no file has them in the order of the physics engine: so the plugin brings the mesh itself.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fire3dv::ambf {

struct SoftMesh {
  std::string name;              // as nodes are named: by key or by name
  std::vector<float> positions;  // 3 for each vertex, in the stream's frame
  std::vector<uint32_t> triangles;
  std::array<float, 4> color_srgb{0.8f, 0.8f, 0.8f, 1};  // as AMBF's materials have it
};

// The added node, and the path to the node below it that has the vertices: what is in an added file goes by
// its path.
std::string soft_node_name(const std::string& name);
std::string soft_vertices_path(const std::string& name);

// Turned to glTF's Y up by its root. Empty where there is nothing to show, or a triangle names no vertex.
std::vector<std::byte> soft_mesh_glb(const SoftMesh& mesh);

}  // namespace fire3dv::ambf
