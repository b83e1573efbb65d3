#include "renderer/app/loading/cache_file.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "renderer/scene/cache/cache_files.h"
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

}  // namespace fire3dv::app
