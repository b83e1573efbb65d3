// Joints of a model of libsdformat as plain data.
#pragma once

#include <cstddef>
#include <map>
#include <sdf/Model.hh>
#include <string>
#include <vector>

#include "convert/sdf/sdf_scene.h"

namespace fire3dv::convert {

// item: of the model. prefix: scoped name of the model, with "::" at its end. links: items of all links by
// their scoped names. where: the model, for warnings.
void add_sdf_joints(const sdf::Model& model, size_t item, const std::string& prefix,
                    const std::map<std::string, size_t>& links, const std::string& where, SdfScene& scene,
                    std::vector<std::string>& warnings);

}  // namespace fire3dv::convert
