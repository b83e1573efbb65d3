#include "tools/convert/local_files.h"

#include <algorithm>
#include <system_error>

#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

bool is_below(const std::filesystem::path& folder, const std::filesystem::path& file) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

}  // namespace

Result<std::filesystem::path> regular_file(const std::filesystem::path& path) {
  const std::string name = quote(path.string());
  if (path.native().find('\0') != std::string::npos) return Error{"the path " + name + " holds a zero byte"};
  std::error_code error;
  const std::filesystem::path resolved = std::filesystem::canonical(path, error);
  if (error) return Error{"cannot open " + name + ": " + error.message()};
  for (const char* made_up : {"/proc", "/sys", "/dev"}) {
    if (is_below(made_up, resolved)) return Error{name + " is no file on a disk"};
  }
  const std::filesystem::file_status status = std::filesystem::status(resolved, error);
  if (error) return Error{"cannot open " + name + ": " + error.message()};
  if (!std::filesystem::is_regular_file(status)) {
    return Error{name + (std::filesystem::is_directory(status) ? " is a folder" : " is not a regular file")};
  }
  return resolved;
}

std::filesystem::path tidy_path(const std::filesystem::path& path) {
  std::filesystem::path tidy;
  for (const std::filesystem::path& part : path)
    if (part != ".") tidy /= part;
  return tidy;
}

void AllowedFolders::add(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::path resolved =
      std::filesystem::canonical(folder.empty() ? std::filesystem::path(".") : folder, error);
  if (error || resolved == resolved.root_path()) return;
  if (std::find(folders_.begin(), folders_.end(), resolved) == folders_.end()) folders_.push_back(resolved);
}

void AllowedFolders::add(const AllowedFolders& others) {
  for (const std::filesystem::path& folder : others.folders_) add(folder);
}

bool AllowedFolders::hold(const std::filesystem::path& resolved) const {
  return std::any_of(folders_.begin(), folders_.end(),
                     [&](const std::filesystem::path& folder) { return is_below(folder, resolved); });
}

}  // namespace fire3dv::convert
