#include "renderer/app/loading/pipeline_cache_file.h"

#include <system_error>

#include "renderer/passes/resources/device_kind.h"
#include "renderer/scene/cache/cache_files.h"

namespace fire3dv::app {

const CacheFileType kPipelineFiles{{"F3DVPIP\0", 8}, ".pipelines", "pipelines"};

Digest pipeline_kind(const VkPhysicalDeviceProperties& device) {
  return passes::device_kind(device, "");
}

PipelineCacheFile::PipelineCacheFile(gpu::Device& device, const std::optional<std::filesystem::path>& folder)
    : device_(device) {
  if (folder) {
    kind_ = pipeline_kind(device.identity());
    folder_ = *folder;
    const std::filesystem::path path = cache_path(folder_, kPipelineFiles, kind_);
    std::error_code error;
    if (std::filesystem::exists(path, error)) {
      auto data = read_cache_file(path, kPipelineFiles, kind_);
      if (data) known_ = std::move(*data);
      if (!data) note_ = data.error().message;
    }
  }
  device.start_pipeline_cache(known_);
}

Result<void> PipelineCacheFile::keep() const {
  if (folder_.empty()) return {};
  const std::vector<std::byte> data = device_.pipeline_cache_data();
  // Drivers with their own cache, such as lavapipe, return no data.
  if (data.empty() || data == known_) {
    if (!known_.empty()) scene::touch(cache_path(folder_, kPipelineFiles, kind_));
    return {};
  }
  return store_in_cache(folder_, kPipelineFiles, kind_, data);
}

}  // namespace fire3dv::app
