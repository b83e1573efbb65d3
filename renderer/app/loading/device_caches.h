// Caches of device-dependent artefacts on disk: compiled pipelines and prefiltered environment maps. Files of
// another device, driver or build, and damaged files, are ignored.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/app/loading/cache_file.h"
#include "renderer/gpu/device/device.h"
#include "renderer/passes/environment/prepared_environment.h"

namespace fire3dv::app {

// Cache key of pipelines: device, driver version and shader digest.
Digest pipeline_kind(const VkPhysicalDeviceProperties& device);

extern const CacheFileType kPipelineFiles;

// Pipeline cache of one run. Without a folder nothing is stored.
class PipelineCacheFile {
 public:
  // Call before the device creates pipelines. note() is set if an existing file was unusable.
  PipelineCacheFile(gpu::Device& device, const std::optional<std::filesystem::path>& folder);
  const std::optional<std::string>& note() const { return note_; }

  // Call after the last pipeline is created: writes the file.
  Result<void> keep() const;

 private:
  gpu::Device& device_;
  Digest kind_{};
  std::filesystem::path folder_;  // empty: none
  std::vector<std::byte> loaded_;
  std::optional<std::string> note_;
};

extern const CacheFileType kEnvironmentFiles;

// Read and write errors are logged and cost only time.
class EnvironmentCache : public passes::EnvironmentStore {
 public:
  explicit EnvironmentCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::optional<std::vector<std::byte>> find(const Digest& kind, size_t bytes) override;
  void keep(const Digest& kind, std::span<const std::byte> maps) override;

 private:
  void wait_for_writer();  // requires mutex_

  std::filesystem::path folder_;
  std::mutex mutex_;     // guards writer_
  std::jthread writer_;  // background write: the flush to disk must not delay the first image
};

// Null without a folder.
std::shared_ptr<passes::EnvironmentStore> environment_store(
    const std::optional<std::filesystem::path>& folder);

}  // namespace fire3dv::app
