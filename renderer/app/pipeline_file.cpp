#include "renderer/app/pipeline_file.h"

#include <system_error>

#include "renderer/passes/device_kind.h"
#include "renderer/scene/cache_files.h"

namespace fire3dv::app {

const KeptFileType kPipelineFiles{{"F3DVPIP\0", 8}, ".pipelines", "pipelines"};

scene::Digest pipeline_kind(const VkPhysicalDeviceProperties& device) {
  return passes::device_kind(device, "");
}

PipelineFile::PipelineFile(gpu::Device& device, const std::optional<std::filesystem::path>& folder)
    : device_(device) {
  if (folder) {
    kind_ = pipeline_kind(device.identity());
    folder_ = *folder;
    const std::filesystem::path path = kept_path(folder_, kPipelineFiles, kind_);
    std::error_code error;
    if (std::filesystem::exists(path, error)) {
      auto data = read_kept_file(path, kPipelineFiles, kind_);
      if (data) known_ = std::move(*data);
      if (!data) note_ = data.error().message;
    }
  }
  device.start_pipeline_cache(known_);
}

Result<void> PipelineFile::keep() const {
  if (folder_.empty()) return {};
  const std::vector<std::byte> data = device_.pipeline_cache_data();
  // A driver with a cache of its own, such as lavapipe, gives nothing.
  if (data.empty() || data == known_) {
    if (!known_.empty()) scene::touch(kept_path(folder_, kPipelineFiles, kind_));
    return {};
  }
  return keep_in_folder(folder_, kPipelineFiles, kind_, data);
}

}  // namespace fire3dv::app
