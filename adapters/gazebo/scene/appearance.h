// Shapes, materials, lights and cameras of Gazebo's messages as those of SDF, whose rules draw them
// (convert/sdf/add_sdf.h). Numbers are taken over as they are.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "convert/sdf/sdf_scene.h"
#include "gazebo.pb.h"

namespace fire3dv::gazebo {

// where: the visual, for warnings. Nullopt: nothing to draw.
std::optional<convert::SdfShape> sdf_shape(const pb::Geometry& geometry, const std::string& where,
                                           std::vector<std::string>& warnings);
convert::SdfMaterial sdf_material(const pb::Material& from, const std::string& where,
                                  std::vector<std::string>& warnings);
// Nullopt: an unknown type.
std::optional<convert::SdfLight> sdf_light(const pb::Light& from, const std::string& where,
                                           std::vector<std::string>& warnings);
convert::SdfCamera sdf_camera(const pb::CameraSensor& from);

}  // namespace fire3dv::gazebo
