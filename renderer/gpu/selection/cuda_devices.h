// CUDA's enumeration of GPUs, to map a CUDA ordinal to a Vulkan device by UUID. The two orders differ: CUDA
// sorts by speed, or by CUDA_DEVICE_ORDER, and leaves out what CUDA_VISIBLE_DEVICES does not name.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fire3dv::gpu {

struct CudaDevice {
  std::string name;
  std::string uuid;     // the form of DeviceReport::uuid
  bool is_mig = false;  // a MIG instance: part of a GPU, without Vulkan
};

// The devices in CUDA's order (cuda:0 first), after CUDA_VISIBLE_DEVICES.
struct CudaDevices {
  std::vector<CudaDevice> devices;
  std::string failure;  // a clause; empty: CUDA answered
};

// Loads the driver's library at run time and initialises CUDA, which may take seconds. The library stays
// loaded.
CudaDevices read_cuda_devices(const std::string& library = "libcuda.so.1");

// First entry of CUDA_VISIBLE_DEVICES. CUDA ends the list at its first invalid entry.
struct CudaVisible {
  enum class Kind { none, ordinal, uuid, mig };
  Kind kind = Kind::none;
  std::string
      uuid;  // Kind::uuid: hexadecimal digits in lower case, without dashes; may be the beginning only
};
CudaVisible parse_cuda_visible(std::string_view value);

}  // namespace fire3dv::gpu
