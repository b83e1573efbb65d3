// Conversion of Gazebo's entities to the model that the glTF writer takes: one node per entity, with meshes,
// materials, lights and cameras.
#pragma once

#include <string>
#include <vector>

#include "adapters/gazebo/scene/resources.h"
#include "adapters/gazebo/world/entities.h"
#include "tools/convert/model.h"

namespace fire3dv::gazebo {

// name: of the root node. What cannot be shown is left out, with a warning in the model. Reads mesh and image
// files.
convert::Model scene_model(const std::vector<TopLevel>& items, const Resources& resources,
                           const std::string& name);

// Pose of the glTF camera, which looks along -Z, in the frame of a Gazebo camera, which looks along +X.
inline constexpr float kSensorFromCamera[12] = {0, 0, -1, 0, -1, 0, 0, 0, 0, 1, 0, 0};

}  // namespace fire3dv::gazebo
