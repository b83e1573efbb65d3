// Experiments with Vulkan: each is for a child process, since a driver may crash or hang in it. Failures are
// exceptions.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace fire3dv::doctor {

// Version and file of the Vulkan loader: {"version", "file"}.
nlohmann::json probe_loader();

// Loads a driver's library as the Vulkan loader does. The exception has the text of dlerror(), or says that
// there is no vkCreateInstance, and which libraries are missing that NVIDIA's driver loads for it.
nlohmann::json probe_library(const std::string& library);

// All devices, and "chosen": the index of the one that fire3dv takes by itself, or null.
nlohmann::json probe_devices();

// The number of devices of one driver alone.
nlohmann::json probe_driver(const std::string& manifest);

// Clears 64x64 pixels, reads them back and compares all.
nlohmann::json probe_read_back(uint32_t device);

// Traces a ray that hits a triangle and one that misses it, by each method that the device claims.
nlohmann::json probe_ray(uint32_t device);

// CUDA's devices in its order: an array of {"name", "uuid", "mig"}. Null: there is no libcuda.
nlohmann::json probe_cuda();

}  // namespace fire3dv::doctor
