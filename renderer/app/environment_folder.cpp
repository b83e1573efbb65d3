#include "renderer/app/environment_folder.h"

#include <system_error>
#include <utility>

#include "renderer/app/start.h"
#include "renderer/scene/atomic_file.h"

namespace fire3dv::app {

const KeptFileType kEnvironmentFiles{{"F3DVENV\0", 8}, ".surroundings", "surroundings"};

std::optional<std::vector<std::byte>> EnvironmentFolder::find(const scene::Digest& kind, size_t bytes) {
  const std::filesystem::path path = kept_path(folder_, kEnvironmentFiles, kind);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  Result<std::vector<std::byte>> maps = read_kept_file(path, kEnvironmentFiles, kind);
  if (!maps) say(maps.error().message);
  if (!maps || maps->size() != bytes) return std::nullopt;
  scene::touch(path);
  return std::move(*maps);
}

void EnvironmentFolder::keep(const scene::Digest& kind, std::span<const std::byte> maps) {
  if (Result<void> kept = keep_in_folder(folder_, kEnvironmentFiles, kind, maps); !kept)
    say_of_cache(kept.error());
}

std::shared_ptr<passes::EnvironmentStore> environment_store(
    const std::optional<std::filesystem::path>& folder) {
  if (!folder) return nullptr;
  return std::make_shared<EnvironmentFolder>(*folder);
}

}  // namespace fire3dv::app
