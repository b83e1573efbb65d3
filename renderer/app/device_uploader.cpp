#include "renderer/app/device_uploader.h"

#include <string>

#include "renderer/live_scene/gpu_bytes.h"

namespace fire3dv::app {
namespace {

Result<void> check_bytes(uint64_t bytes, const gpu::Device& device) {
  const uint64_t available = device.available_bytes();
  if (bytes <= available) return {};
  return Error{"the scene with it takes about " + std::to_string(bytes >> 20) + " MiB, but " +
               device.report().name + " has " + std::to_string(available >> 20) +
               " MiB of memory left beside what is shown"};
}

}  // namespace

// The displayed scene keeps its memory until the next one is uploaded.
Result<void> DeviceUploader::check_memory(const scene::LoadedScene& next) const {
  const uint64_t bytes = estimate_gpu_bytes(next.scene, next.derived);
  Result<void> fits = check_bytes(bytes, renderer_.device());
  for (const gpu::Device* device : secondary_) {
    if (fits) fits = check_bytes(bytes, *device);
  }
  return fits;
}

Result<void> DeviceUploader::upload(const scene::LoadedScene& next) {
  try {
    renderer_.set_scene(next.scene, next.derived);
    return {};
  } catch (const gpu::VulkanFailure& failure) {
    if (!gpu::is_out_of_memory(failure)) throw;
    return Error{"the device has no memory for the scene with it"};
  }
}

}  // namespace fire3dv::app
