#include "renderer/app/loading/device_caches.h"

#include <system_error>
#include <utility>

#include "renderer/app/start.h"
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
      if (data) loaded_ = std::move(*data);
      if (!data) note_ = data.error().message;
    }
  }
  device.start_pipeline_cache(loaded_);
}

Result<void> PipelineCacheFile::keep() const {
  if (folder_.empty()) return {};
  const std::vector<std::byte> data = device_.pipeline_cache_data();
  // Drivers with their own cache, such as lavapipe, return no data.
  if (data.empty() || data == loaded_) {
    if (!loaded_.empty()) scene::touch(cache_path(folder_, kPipelineFiles, kind_));
    return {};
  }
  return store_in_cache(folder_, kPipelineFiles, kind_, data);
}

const CacheFileType kEnvironmentFiles{{"F3DVENV\0", 8}, ".environment", "environment maps"};

std::optional<std::vector<std::byte>> EnvironmentCache::find(const Digest& kind, size_t bytes) {
  const std::lock_guard lock(mutex_);
  wait_for_writer();
  const std::filesystem::path path = cache_path(folder_, kEnvironmentFiles, kind);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  Result<std::vector<std::byte>> maps = read_cache_file(path, kEnvironmentFiles, kind);
  if (!maps) say(maps.error().message);
  if (!maps || maps->size() != bytes) return std::nullopt;
  scene::touch(path);
  return std::move(*maps);
}

void EnvironmentCache::wait_for_writer() {
  if (writer_.joinable()) writer_.join();
}

void EnvironmentCache::keep(const Digest& kind, std::span<const std::byte> maps) {
  const std::lock_guard lock(mutex_);
  wait_for_writer();
  writer_ = std::jthread([folder = folder_, kind, data = std::vector(maps.begin(), maps.end())] {
    if (Result<void> stored = store_in_cache(folder, kEnvironmentFiles, kind, data); !stored)
      log_cache_error(stored.error());
  });
}

std::shared_ptr<passes::EnvironmentStore> environment_store(
    const std::optional<std::filesystem::path>& folder) {
  if (!folder) return nullptr;
  return std::make_shared<EnvironmentCache>(*folder);
}

}  // namespace fire3dv::app
