// The fields of ADF: those that make the picture and those that only the simulation needs.
#pragma once

#include <string_view>

namespace fire3dv::convert {

bool is_adf_field(std::string_view name);

}  // namespace fire3dv::convert
