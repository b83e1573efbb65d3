#include "convert/glb/cache_entry.h"

#include <string>
#include <system_error>

#include "base/text.h"
#include "renderer/scene/cache_files.h"

namespace fire3dv::convert {

namespace fs = std::filesystem;

Result<void> write_cache_entry(const fs::path& path, std::span<const std::byte> bytes) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_symlink(status))
    return Error{"cannot write " + quote(path.string()) + ": it is there, and is not a regular file"};
  return scene::write_cache_file(path, {bytes});
}

}  // namespace fire3dv::convert
