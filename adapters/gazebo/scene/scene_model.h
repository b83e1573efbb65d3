// Conversion of Gazebo's entities to the model that the glTF writer takes: one node per entity, with meshes,
// materials, lights and cameras, by the rules of SDF files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "adapters/gazebo/world/entities.h"
#include "convert/model.h"

namespace fire3dv::gazebo {

// name: of the root node. resource_folders: contain models or packages, or are some; searched before those of
// Gazebo's variables (convert/sdf/files/sdf_files.h). What cannot be shown is left out, with a warning
// in the model. Reads mesh and image files.
convert::Model scene_model(const std::vector<TopLevel>& items,
                           const std::vector<std::filesystem::path>& resource_folders,
                           const std::string& name);

}  // namespace fire3dv::gazebo
