// JSON schema check for glTF before tinygltf. tinygltf ignores members of a wrong type, truncates integers
// and keeps unknown members. Here wrong types are errors that name the member, and unknown members are
// removed.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "protocol/base/error.h"

namespace fire3dv::scene {

// True for extensions that the loader implements.
bool extension_supported(const std::string& name);

// Validates and reduces the document in place. Warnings name removed parts.
Result<void> check_and_reduce(nlohmann::json& document, std::vector<std::string>& warnings);

}  // namespace fire3dv::scene
