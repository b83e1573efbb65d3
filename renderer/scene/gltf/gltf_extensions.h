// Extensions of glTF that the loader does not implement, and what is missing in the image without them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace fire3dv::scene {

// The effect of leaving an extension out, if it changes only appearance, lighting, behaviour or metadata.
// Empty: unknown; it may change geometry or data.
std::string_view effect_of_omission(std::string_view extension);

// Reads extensionsUsed and extensionsRequired. Unsupported extensions become one warning, with their effects.
// A required extension of unknown effect is an error.
Result<void> check_extensions(const nlohmann::json& document, std::vector<std::string>& warnings);

}  // namespace fire3dv::scene
