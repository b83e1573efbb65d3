#include "renderer/gpu/device/driver_files.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "base/text.h"

namespace fire3dv::gpu {

std::string describe_driver_files(const std::function<const char*(const char*)>& environment) {
  for (const char* name : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"}) {  // the loader ignores the second then
    const char* const value = environment(name);
    if (!value || !*value) continue;
    const std::string_view paths = value;
    for (size_t begin = 0; begin <= paths.size();) {
      const size_t end = std::min(paths.find(':', begin), paths.size());
      const std::string path(paths.substr(begin, end - begin));
      std::error_code ignored;
      if (!path.empty() && !std::filesystem::exists(path, ignored))
        return std::string("; the environment variable ") + name + " names " + quote(path) +
               ", which does not exist: correct or unset it";
      begin = end + 1;
    }
    return std::string("; the environment variable ") + name + " leaves only the drivers of " + quote(paths) +
           ": correct or unset it";
  }
  return "";
}

std::string driver_advice(const std::function<const char*(const char*)>& environment) {
  return "install your GPU's Vulkan driver (NVIDIA's also needs libegl1) or, for the CPU, "
         "mesa-vulkan-drivers "
         "(where FIRE-3DV is from a wheel: install the file fire3dv_cpu-*.whl, too, docs/install.md)" +
         describe_driver_files(environment);
}

}  // namespace fire3dv::gpu
