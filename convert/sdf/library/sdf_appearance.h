// Shapes, materials, lights and cameras of libsdformat as plain data.
#pragma once

#include <optional>
#include <sdf/Camera.hh>
#include <sdf/Geometry.hh>
#include <sdf/Light.hh>
#include <sdf/Material.hh>
#include <string>
#include <vector>

#include "convert/sdf/files/sdf_documents.h"
#include "convert/sdf/sdf_scene.h"

namespace fire3dv::convert {

// where: the entity, for warnings, which begin with it. Empty: nothing is drawn.
std::optional<SdfShape> sdf_shape(const sdf::Geometry& geometry, const SdfDocuments& documents,
                                  const std::string& where, std::vector<std::string>& warnings);
SdfMaterial sdf_material(const sdf::Material& material, const SdfDocuments& documents,
                         const std::string& where, std::vector<std::string>& warnings);
SdfLight sdf_light(const sdf::Light& light);
SdfCamera sdf_camera(const sdf::Camera& camera, const std::string& where, std::vector<std::string>& warnings);

}  // namespace fire3dv::convert
