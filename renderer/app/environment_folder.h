// Prepared surroundings in a folder of the cache.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "renderer/app/kept_file.h"
#include "renderer/passes/kept_environment.h"

namespace fire3dv::app {

extern const KeptFileType kEnvironmentFiles;

// What cannot be read or written is said, and costs time alone.
class EnvironmentFolder : public passes::EnvironmentStore {
 public:
  explicit EnvironmentFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::optional<std::vector<std::byte>> find(const scene::Digest& kind, size_t bytes) override;
  void keep(const scene::Digest& kind, std::span<const std::byte> maps) override;

 private:
  void wait_for_writer();  // mutex_ is held

  std::filesystem::path folder_;
  std::mutex mutex_;     // of writer_
  std::jthread writer_;  // the flush to the disk must not delay the first image
};

// Null without a folder.
std::shared_ptr<passes::EnvironmentStore> environment_store(
    const std::optional<std::filesystem::path>& folder);

}  // namespace fire3dv::app
