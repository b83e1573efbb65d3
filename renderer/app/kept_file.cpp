#include "renderer/app/kept_file.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "renderer/scene/cache_files.h"
#include "renderer/scene/files.h"

namespace fire3dv::app {
namespace {

struct Head {
  char magic[8];
  scene::Digest kind;
  uint64_t data_bytes;
  uint64_t checksum;  // of the data
};
static_assert(sizeof(Head) == 56);

uint64_t checksum_of(std::span<const std::byte> bytes) {
  scene::Checksum checksum;
  checksum.add(bytes);
  return checksum.value();
}

}  // namespace

std::filesystem::path kept_path(const std::filesystem::path& folder, const KeptFileType& type,
                                const scene::Digest& kind) {
  return folder / (scene::hex(std::span(kind).first(16)) + std::string(type.ending));
}

Result<void> write_kept_file(const std::filesystem::path& path, const KeptFileType& type,
                             const scene::Digest& kind, std::span<const std::byte> data) {
  Head head{};
  std::copy(type.magic.begin(), type.magic.end(), head.magic);
  head.kind = kind;
  head.data_bytes = data.size();
  head.checksum = checksum_of(data);
  return scene::write_cache_file(path, {std::as_bytes(std::span(&head, 1)), data});
}

Result<std::vector<std::byte>> read_kept_file(const std::filesystem::path& path, const KeptFileType& type,
                                              const scene::Digest& kind) {
  const auto unusable = [&](const std::string& why) {
    return Error{"cache: " + scene::quote(path.string()) + " is made anew: " + why};
  };
  Result<scene::OpenFile> file = scene::OpenFile::open(path, kMostKeptBytes);
  if (!file) return Error{"cache: " + file.error().message};
  Head head{};
  if (!file->read(0, std::as_writable_bytes(std::span(&head, 1)))) return unusable("it is too short");
  if (std::string_view(head.magic, sizeof(head.magic)) != type.magic)
    return unusable(std::string("it holds no ") + type.holds);
  if (head.kind != kind) return unusable("it is of another device, driver or version of this program");
  if (head.data_bytes != file->size() - sizeof(Head)) return unusable("it is not of the length that it says");
  std::vector<std::byte> data(head.data_bytes);
  if (!file->read(sizeof(Head), data) || checksum_of(data) != head.checksum) return unusable("it is damaged");
  return data;
}

Result<void> keep_in_folder(const std::filesystem::path& folder, const KeptFileType& type,
                            const scene::Digest& kind, std::span<const std::byte> data) {
  if (data.size() > kMostKeptBytes - sizeof(Head)) return {};
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{"cannot make the folder " + scene::quote(folder.string()) + ": " + error.message()};
  Result<void> written = write_kept_file(kept_path(folder, type, kind), type, kind, data);
  scene::remove_oldest(folder, type.ending, kMostKeptBytes);
  return written;
}

}  // namespace fire3dv::app
