#include "renderer/loading/disk_caches.h"

#include <algorithm>
#include <atomic>
#include <system_error>
#include <utility>

#include "base/log.h"
#include "renderer/gpu/pipelines/pipeline.h"
#include "renderer/scene/cache_files.h"
#include "renderer/scene/files.h"

namespace fire3dv::app {

namespace {

struct Head {
  char magic[8];
  Digest kind;
  uint64_t data_bytes;
  uint64_t checksum;  // of the data
};
static_assert(sizeof(Head) == 56);

uint64_t checksum_of(std::span<const std::byte> bytes) {
  Checksum checksum;
  checksum.add(bytes);
  return checksum.value();
}

}  // namespace

std::filesystem::path cache_path(const std::filesystem::path& folder, const CacheFileType& type,
                                 const Digest& kind) {
  return folder / (hex(std::span(kind).first(16)) + std::string(type.ending));
}

Result<void> store_cache_file(const std::filesystem::path& path, const CacheFileType& type,
                              const Digest& kind, std::span<const std::byte> data) {
  Head head{};
  std::copy(type.magic.begin(), type.magic.end(), head.magic);
  head.kind = kind;
  head.data_bytes = data.size();
  head.checksum = checksum_of(data);
  return scene::write_cache_file(path, {std::as_bytes(std::span(&head, 1)), data});
}

Result<std::vector<std::byte>> read_cache_file(const std::filesystem::path& path, const CacheFileType& type,
                                               const Digest& kind) {
  const auto unusable = [&](const std::string& why) {
    return Error{"cache: " + quote(path.string()) + " is rebuilt: " + why};
  };
  Result<OpenFile> file = OpenFile::open(path, kMaxCacheBytes);
  if (!file) return Error{"cache: " + file.error().message};
  Head head{};
  if (!file->read(0, std::as_writable_bytes(std::span(&head, 1)))) return unusable("it is too short");
  if (std::string_view(head.magic, sizeof(head.magic)) != type.magic)
    return unusable(std::string("it holds no ") + type.holds);
  if (head.kind != kind) return unusable("it is of another device, driver or version of this program");
  if (head.data_bytes != file->size() - sizeof(Head)) return unusable("its length differs from its header");
  std::vector<std::byte> data(head.data_bytes);
  if (!file->read(sizeof(Head), data) || checksum_of(data) != head.checksum) return unusable("it is damaged");
  return data;
}

Result<void> store_in_cache(const std::filesystem::path& folder, const CacheFileType& type,
                            const Digest& kind, std::span<const std::byte> data) {
  if (data.size() > kMaxCacheBytes - sizeof(Head)) return {};
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{"cannot make the folder " + quote(folder.string()) + ": " + error.message()};
  Result<void> written = store_cache_file(cache_path(folder, type, kind), type, kind, data);
  scene::remove_oldest(folder, type.ending, kMaxCacheBytes);
  return written;
}

namespace {

using Place = scene::SceneCacheSettings::Place;

// The XDG specification requires that relative paths are ignored.
std::optional<std::filesystem::path> absolute(const char* value) {
  if (!value || *value != '/') return std::nullopt;
  return std::filesystem::path(value);
}

std::optional<std::filesystem::path> user_folder(const std::function<const char*(const char*)>& environment) {
  if (const auto cache = absolute(environment("XDG_CACHE_HOME"))) return *cache / "fire3dv";
  if (const auto home = absolute(environment("HOME"))) return *home / ".cache" / "fire3dv";
  return std::nullopt;
}

}  // namespace

void log_cache_error(const Error& error) {
  static std::atomic_flag reported;  // a read-only folder fails once for each kind of file
  if (reported.test_and_set()) return;
  log_message(warning("cache: " + error.message +
                      "; the next start will be as slow as this one (--cache names another folder)"));
}

CacheLocations find_cache_locations(std::string_view wanted,
                                    const std::function<const char*(const char*)>& environment) {
  CacheLocations caches;
  if (wanted == "off") return caches;
  const bool named = wanted != "auto" && wanted != "beside";
  const std::optional<std::filesystem::path> folder =
      named ? std::optional<std::filesystem::path>(wanted) : user_folder(environment);
  if (folder) {
    caches.pipelines = *folder / "pipelines";
    caches.environments = *folder / "environments";
    caches.scenes.place = Place::folder;
    caches.scenes.folder = *folder / "scenes";
  }
  if (wanted == "beside") caches.scenes.place = Place::beside_the_asset;
  return caches;
}

const CacheFileType kPipelineFiles{{"F3DVPIP\0", 8}, ".pipelines", "pipelines"};

Digest pipeline_kind(const VkPhysicalDeviceProperties& device) {
  return gpu::device_kind(device, "");
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
  if (!maps) log_message(warning(maps.error().message));
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
