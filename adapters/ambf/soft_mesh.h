// Soft body mesh encoded as a GLB asset. Streamed vertices must match the asset's vertex order. No scene file
// has the physics engine's order, so the plugin adds its own mesh.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fire3dv::ambf {

struct SoftMesh {
  std::string name;              // key or name, as for nodes
  std::vector<float> positions;  // x y z per vertex, in the stream frame, metres
  std::vector<uint32_t> triangles;
  std::array<float, 4> color_srgb{0.8f, 0.8f, 0.8f, 1};  // sRGB, as in AMBF's materials
};

// Name of the added node, and path of the mesh node inside its asset.
std::string soft_node_name(const std::string& name);
std::string soft_vertices_path(const std::string& name);

// Encodes the mesh below a root that rotates to glTF's Y up. Empty for an empty mesh or an index out of
// range.
std::vector<std::byte> soft_mesh_glb(const SoftMesh& mesh);

}  // namespace fire3dv::ambf
