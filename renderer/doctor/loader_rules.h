// Rules of the Vulkan loader for environment variables: versions that read them, and filters of names.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace fire3dv::doctor {

// As VK_MAKE_API_VERSION.
constexpr uint32_t make_version(uint32_t major, uint32_t minor, uint32_t patch) {
  return major << 22 | minor << 12 | patch;
}
std::string version_text(uint32_t version);

// The first versions that read VK_DRIVER_FILES and VK_ADD_DRIVER_FILES; VK_LOADER_DRIVERS_* and
// VK_LOADER_LAYERS_* but ..._ALLOW; VK_LOADER_LAYERS_ALLOW; VK_IMPLICIT_LAYER_PATH and
// VK_ADD_IMPLICIT_LAYER_PATH.
constexpr uint32_t kReadsDriverFiles = make_version(1, 3, 207);
constexpr uint32_t kReadsFilters = make_version(1, 3, 234);
constexpr uint32_t kReadsAllow = make_version(1, 3, 262);
constexpr uint32_t kReadsLayerPaths = make_version(1, 3, 296);

// True if a name matches an entry of a filter such as "*nvidia*,lvp_icd.json": entries are separated by
// commas, have stars at their ends alone, and match in any letter case.
bool matches_filter(std::string_view filter, std::string_view name);

}  // namespace fire3dv::doctor
