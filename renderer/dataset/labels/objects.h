// Labelled objects of a scene: instances with their models, and the models as PLY files.
#pragma once

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/dataset/labels/description.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::dataset {

// Fills objects, instances and warnings. wanted: names or paths of nodes whose meshes, or those of their
// descendants, are labelled; empty: all nodes with triangles. without: nodes without labels. Fails for a name
// that no node has.
Result<void> find_objects(const scene::Scene& scene, std::span<const std::string> wanted,
                          Description& description, const std::set<uint32_t>& without = {});

// Binary PLY with positions in millimetres and normals, in the axes of poses cam_R_m2c. object: its index.
std::vector<uint8_t> encode_model(const scene::Scene& scene, const Description& description, size_t object);

}  // namespace fire3dv::dataset
