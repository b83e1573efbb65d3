// Mesh assets of MJCF: triangles in the frame of their geoms, and the inertia frame that MuJoCo fits
// primitives to.
#pragma once

#include <glm/glm.hpp>
#include <memory>

#include "base/error.h"
#include "convert/mjcf/assets/mesh_data.h"
#include "convert/mjcf/scene/mjcf_scene.h"
#include "convert/mjcf/xml/mjcf_element.h"
#include "convert/model.h"

namespace fire3dv::convert {

class MjcfSource;
struct MjcfMeshAsset;

struct MjcfMesh {
  std::shared_ptr<const Surface> surface;
  // Frame of the principal axes of inertia, at the centre of mass; the largest moment is about its X axis.
  MjcfPose inertia_pose;
  glm::dvec3 inertia_half{0};           // half extents of the box with equal inertia
  glm::dvec3 low{0}, high{0};           // bounds in the inertia frame
  double volume = 0, bound_radius = 0;  // radius: of a sphere at the centre of mass
};

// Reads the triangles of an element's file or attributes, as they are there, with equal vertices shared. The
// error is a sentence end about the element.
Result<MeshData> read_mjcf_mesh_data(MjcfSource& source, const MjcfElement& element);

// Reads the mesh of an asset element from its file or its own attributes. The error is a sentence end about
// the asset.
Result<std::shared_ptr<const MjcfMesh>> read_mjcf_mesh(MjcfSource& source, const MjcfMeshAsset& asset);

// Size of a primitive that replaces a mesh, and its centre in the inertia frame.
struct MjcfFit {
  glm::dvec3 size{0}, centre{0};
};
MjcfFit fit_mjcf_mesh(const MjcfMesh& mesh, MjcfShape shape, bool fits_bounds);

}  // namespace fire3dv::convert
