// Caches on disk: their locations, the format of cache files, and the caches of device-dependent artefacts
// (compiled pipelines and prefiltered environment maps). Files of another device, driver or build, and
// damaged files, are ignored.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/digest.h"
#include "base/error.h"
#include "renderer/gpu/device/device.h"
#include "renderer/passes/environment/environment_store.h"
#include "renderer/scene/cache/scene_cache.h"

namespace fire3dv::app {

// Reports the process's first cache error, which only costs time. Thread-safe.
void log_cache_error(const Error& error);

// --- cache files: key, checksum and data; a read returns exactly the written bytes or an error ---

// Type of the files in a cache folder.
struct CacheFileType {
  std::string_view magic;   // 8 bytes
  std::string_view ending;  // file extension
  const char* holds;        // for messages: "pipelines"
};
// Limit of one file, and of all files of a type in a folder.
constexpr uint64_t kMaxCacheBytes = uint64_t{256} << 20;

// File path of a cache key.
std::filesystem::path cache_path(const std::filesystem::path& folder, const CacheFileType& type,
                                 const Digest& kind);
// Replaces the file atomically.
Result<void> store_cache_file(const std::filesystem::path& path, const CacheFileType& type,
                              const Digest& kind, std::span<const std::byte> data);
// Errors name the file and the reason: other key or type, damaged, too long, or missing.
Result<std::vector<std::byte>> read_cache_file(const std::filesystem::path& path, const CacheFileType& type,
                                               const Digest& kind);
// Writes the file to cache_path(), creates the folder if needed, and evicts the oldest files over the limit.
Result<void> store_in_cache(const std::filesystem::path& folder, const CacheFileType& type,
                            const Digest& kind, std::span<const std::byte> data);

// Cache locations: loaded scenes, compiled pipelines and prefiltered environment maps.
struct CacheLocations {
  scene::SceneCacheSettings scenes;
  std::optional<std::filesystem::path> pipelines, environments;  // folders
};

// Resolves the value of --cache. "auto": the XDG cache folder, if the environment defines one; "beside":
// scenes next to their files; "off": no cache; otherwise a folder. environment: same interface as
// std::getenv.
CacheLocations find_cache_locations(std::string_view wanted,
                                    const std::function<const char*(const char*)>& environment);

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
