#include "renderer/scene/cache/cache_files.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <system_error>

#include "protocol/base/atomic_file.h"

namespace fire3dv::scene {
namespace {

constexpr std::chrono::hours kPartLifetime{1};

}  // namespace

Result<void> write_cache_file(const std::filesystem::path& path,
                              const std::vector<std::span<const std::byte>>& pieces) {
  return base::write_atomically(path, pieces, {.mode = 0600, .durability = base::Durability::contents});
}

void remove_oldest(const std::filesystem::path& folder, std::string_view ending, uint64_t most_bytes) {
  namespace fs = std::filesystem;
  struct Entry {
    fs::path path;
    fs::file_time_type used;
    uint64_t bytes;
  };
  std::vector<Entry> all;
  uint64_t bytes = 0;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code fault;
    const std::string name = entry->path().filename().string();
    if (entry->is_symlink(fault) || !entry->is_regular_file(fault)) continue;
    const auto used = entry->last_write_time(fault);
    const uint64_t size = fault ? 0 : entry->file_size(fault);
    if (fault) continue;
    const size_t mark = name.rfind(base::kTemporaryMark);
    if (mark != std::string::npos && name.substr(0, mark).ends_with(ending)) {
      if (fs::file_time_type::clock::now() - used > kPartLifetime) fs::remove(entry->path(), fault);
    } else if (name.ends_with(ending)) {
      all.push_back({entry->path(), used, size});
      bytes += size;
    }
  }
  std::sort(all.begin(), all.end(), [](const Entry& a, const Entry& b) { return a.used < b.used; });
  for (const Entry& entry : all) {
    if (bytes <= most_bytes) return;
    std::error_code fault;
    if (fs::remove(entry.path, fault)) bytes -= entry.bytes;
  }
}

void touch(const std::filesystem::path& path) {
  ::utimensat(AT_FDCWD, path.c_str(), nullptr, AT_SYMLINK_NOFOLLOW);
}

}  // namespace fire3dv::scene
