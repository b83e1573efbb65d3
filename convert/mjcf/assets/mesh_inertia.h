// Mass properties of a triangle mesh.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "convert/mjcf/assets/mesh_data.h"
#include "convert/mjcf/assets/mjcf_mesh.h"

namespace fire3dv::convert {

// How MuJoCo computes volumes: signed, as a shell, or (legacy) with pyramids to the centre of the faces that
// all count as positive, which suits meshes that are not closed.
enum class MeshVolume { legacy, exact, shell };

// Fills volume, inertia frame and bounds.
void add_mesh_inertia(const std::vector<glm::dvec3>& vertices, const std::vector<MeshData::Triangle>& faces,
                      MeshVolume kind, MjcfMesh& mesh);

}  // namespace fire3dv::convert
