// Field names of ADF (AMBF description format), for rendering and for simulation. Unknown names are likely
// typos.
#pragma once

#include <string_view>

namespace fire3dv::convert {

bool is_adf_field(std::string_view name);

}  // namespace fire3dv::convert
