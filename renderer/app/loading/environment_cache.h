// Cache folder of prefiltered environment maps.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "renderer/app/loading/cache_file.h"
#include "renderer/passes/environment/prepared_environment.h"

namespace fire3dv::app {

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
