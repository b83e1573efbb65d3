#include "renderer/app/loading/environment_cache.h"

#include <system_error>
#include <utility>

#include "renderer/app/start.h"
#include "renderer/scene/cache/cache_files.h"

namespace fire3dv::app {

const CacheFileType kEnvironmentFiles{{"F3DVENV\0", 8}, ".surroundings", "surroundings"};

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
    if (Result<void> kept = store_in_cache(folder, kEnvironmentFiles, kind, data); !kept)
      log_cache_error(kept.error());
  });
}

std::shared_ptr<passes::EnvironmentStore> environment_store(
    const std::optional<std::filesystem::path>& folder) {
  if (!folder) return nullptr;
  return std::make_shared<EnvironmentCache>(*folder);
}

}  // namespace fire3dv::app
