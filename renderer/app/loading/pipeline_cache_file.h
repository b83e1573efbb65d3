// Pipeline cache on disk. Files of another device, driver or build, and damaged files, are never passed to
// the driver, which validates the rest itself.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/app/loading/cache_file.h"
#include "renderer/gpu/device/device.h"

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
  std::vector<std::byte> known_;
  std::optional<std::string> note_;
};

}  // namespace fire3dv::app
