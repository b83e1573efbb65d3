// Environment variables that replace the installed Vulkan drivers by named manifest files. One that leads
// nowhere looks like a machine without a driver.
#pragma once

#include <functional>
#include <string>

namespace fire3dv::gpu {

// What VK_DRIVER_FILES, or VK_ICD_FILENAMES of older loaders, has to do with a missing driver: a clause for
// an error, starting with a separator; empty if neither is set. environment: getenv.
std::string describe_driver_files(const std::function<const char*(const char*)>& environment);

// What to do without a driver: which ones there are to install, and describe_driver_files.
std::string driver_advice(const std::function<const char*(const char*)>& environment);

}  // namespace fire3dv::gpu
