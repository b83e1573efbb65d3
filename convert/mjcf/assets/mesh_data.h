// Triangles of a mesh file or of inline data, before MuJoCo's transformations, and their parsers. All indices
// are in bounds and all vertices finite. Errors are sentence ends about the mesh.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace fire3dv::convert {

struct MeshData {
  using Triangle = std::array<uint32_t, 3>;
  std::vector<glm::vec3> vertices, normals;
  std::vector<glm::vec2> uvs;          // v grows downwards in the image
  std::vector<Triangle> faces;         // empty: points, whose convex hull is the mesh
  std::vector<Triangle> normal_faces;  // into normals; empty, or one per face
  std::vector<Triangle> uv_faces;      // into uvs; empty, or one per face
};

// Binary STL. Equal vertices are shared.
Result<MeshData> parse_stl(std::string_view bytes);
// MuJoCo's binary format.
Result<MeshData> parse_msh(std::string_view bytes);
// Wavefront OBJ: v, vt, vn and f. Materials, lines and points are ignored.
Result<MeshData> parse_obj(std::string_view text);

// Vertices, normals, texture coordinates and faces as numbers in text. has_*: whether they are given.
struct InlineMesh {
  std::string_view vertices, normals, uvs, faces;
};
Result<MeshData> parse_inline_mesh(const InlineMesh& text);

// Checks the indices of all faces and that vertices are finite and at most 2^30 from the origin.
Result<void> check_mesh_data(const MeshData& mesh);

}  // namespace fire3dv::convert
