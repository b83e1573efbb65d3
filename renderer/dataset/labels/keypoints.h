// Named points of nodes, from the extras of a glTF file and from a side file.
#pragma once

#include <filesystem>

#include "base/error.h"
#include "renderer/dataset/labels/description.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::dataset {

// Fills Description::keypoints; after find_objects(). The scene's file may have them in the extras of nodes:
// "keypoints": {"tip": [x, y, z]}, metres in the node's axes; wrong ones become warnings. side_file: {"NODE":
// {"tip": [x, y, z]}}, by name or path of the node; empty: none. All nodes of a name get its points, which
// replace those in the extras that have their names. Fails for a side file with wrong points, or with a node
// that the scene lacks.
Result<void> read_keypoints(const scene::Scene& scene, const std::filesystem::path& side_file,
                            Description& description);

}  // namespace fire3dv::dataset
