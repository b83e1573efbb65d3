// tinygltf passes over members of a wrong type in silence, truncates integers and keeps whatever it does not
// know. Here the JSON is brought to what tinygltf reads rightly: members of a wrong type are refused by name,
// unknown ones are taken out.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::scene {

// Extensions that the loader understands.
bool extension_supported(const std::string& name);

// Checks and reduces the document in place. Warnings name what is left out.
Result<void> check_and_reduce(nlohmann::json& document, std::vector<std::string>& warnings);

}  // namespace fire3dv::scene
