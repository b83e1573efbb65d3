#include "renderer/gpu/selection/cuda_devices.h"

#include <dlfcn.h>

#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>

#include "base/text.h"
#include "renderer/gpu/device/device_report.h"

namespace fire3dv::gpu {
namespace {

// The part of CUDA's driver interface in use. CUresult and CUdevice are int, CUuuid is 16 bytes.
using CudaUuid = std::array<uint8_t, VK_UUID_SIZE>;
struct CudaFunctions {
  int (*init)(unsigned) = nullptr;
  int (*count)(int*) = nullptr;
  int (*get)(int*, int) = nullptr;
  int (*name)(char*, int, int) = nullptr;
  int (*uuid)(CudaUuid*, int) = nullptr;           // of the GPU, also for a MIG instance
  int (*instance_uuid)(CudaUuid*, int) = nullptr;  // of the MIG instance; null in old drivers
  int (*error_name)(int, const char**) = nullptr;
};

template <typename Function>
bool load_symbol(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(::dlsym(library, name));
  return function != nullptr;
}

std::string result_text(const CudaFunctions& cuda, const char* call, int result) {
  const char* name = nullptr;
  if (cuda.error_name(result, &name) != 0 || !name) name = "error";
  return std::string(call) + " returned " + name + " (" + std::to_string(result) + ")";
}

}  // namespace

CudaDevices read_cuda_devices(const std::string& library) {
  CudaDevices read;
  void* const handle = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) {
    const char* const reason = ::dlerror();
    read.failure =
        "CUDA's driver library cannot be loaded (" + printable_text(reason ? reason : library, 300) + ")";
    return read;
  }
  CudaFunctions cuda;
  if (!load_symbol(handle, "cuInit", cuda.init) || !load_symbol(handle, "cuDeviceGetCount", cuda.count) ||
      !load_symbol(handle, "cuDeviceGet", cuda.get) || !load_symbol(handle, "cuDeviceGetName", cuda.name) ||
      !load_symbol(handle, "cuDeviceGetUuid", cuda.uuid) ||
      !load_symbol(handle, "cuGetErrorName", cuda.error_name)) {
    read.failure = library + " is older than CUDA 9.2: it cannot name the UUIDs of its devices";
    return read;
  }
  load_symbol(handle, "cuDeviceGetUuid_v2", cuda.instance_uuid);
  constexpr int kNoDevice = 100;  // CUDA_ERROR_NO_DEVICE: an empty list
  if (const int result = cuda.init(0); result != 0) {
    if (result != kNoDevice) read.failure = result_text(cuda, "cuInit", result);
    return read;
  }
  int count = 0;
  if (const int result = cuda.count(&count); result != 0) {
    read.failure = result_text(cuda, "cuDeviceGetCount", result);
    return read;
  }
  for (int i = 0; i < count; ++i) {
    int device = 0;
    char name[256] = "";
    CudaUuid uuid{}, instance{};
    if (const int result = cuda.get(&device, i); result != 0 || cuda.uuid(&uuid, device) != 0) {
      read.failure = result_text(cuda, "cuDeviceGet", result);
      return read;
    }
    cuda.name(name, sizeof name - 1, device);
    const bool is_mig = cuda.instance_uuid && cuda.instance_uuid(&instance, device) == 0 && instance != uuid;
    read.devices.push_back({printable_text(name, sizeof name), uuid_text(uuid), is_mig});
  }
  return read;
}

CudaVisible parse_cuda_visible(std::string_view value) {
  const std::string first = lower_case(std::string(value.substr(0, value.find(','))));
  const size_t begin = first.find_first_not_of(" \t");
  const std::string_view entry =
      begin == std::string::npos ? std::string_view() : std::string_view(first).substr(begin);
  CudaVisible visible;
  if (entry.starts_with("mig-")) {
    visible.kind = CudaVisible::Kind::mig;
  } else if (entry.starts_with("gpu-")) {
    for (const char c : entry.substr(4)) {
      if (std::isxdigit(static_cast<unsigned char>(c))) visible.uuid += c;
    }
    if (!visible.uuid.empty()) visible.kind = CudaVisible::Kind::uuid;
  } else if (!entry.empty() && entry[0] >= '0' && entry[0] <= '9') {
    visible.kind = CudaVisible::Kind::ordinal;
  }
  return visible;
}

}  // namespace fire3dv::gpu
