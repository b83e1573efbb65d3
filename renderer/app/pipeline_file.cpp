#include "renderer/app/pipeline_file.h"

#include <span>
#include <system_error>

#include "renderer/scene/atomic_file.h"
#include "shaders/embedded.h"

namespace fire3dv::app {

const KeptFileType kPipelineFiles{{"F3DVPIP\0", 8}, ".pipelines", "pipelines"};

scene::Digest pipeline_kind(const VkPhysicalDeviceProperties& device) {
  std::string text = std::string(device.deviceName) + '\0';
  for (const uint32_t number : {device.vendorID, device.deviceID, device.driverVersion, device.apiVersion})
    text += std::to_string(number) + '\0';
  text += scene::hex(device.pipelineCacheUUID);
  for (const std::string_view name : shaders::names()) {
    const std::span<const uint32_t> code = shaders::embedded(name);
    text += name;
    text.append(reinterpret_cast<const char*>(code.data()), code.size_bytes());
  }
  return scene::digest_of(std::as_bytes(std::span(text)));
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
