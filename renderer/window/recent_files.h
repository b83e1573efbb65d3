// List of the files that windows have shown, the newest first, kept in the user's state folder.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace fire3dv::app {

// Below XDG_STATE_HOME or ~/.local/state; nothing if neither is known.
std::optional<std::filesystem::path> recent_files_path(
    const std::function<const char*(const char*)>& environment);

class RecentFiles {
 public:
  static constexpr size_t kMaxFiles = 10;

  // place: file of the list; nullopt: none is kept.
  explicit RecentFiles(std::optional<std::filesystem::path> place) : place_(std::move(place)) {}

  // Puts a file at the front of the list, and writes it atomically. Reads it first, since other windows add
  // to it. A list that cannot be read starts empty.
  Result<void> add(const std::filesystem::path& shown);
  // Of the last add().
  const std::vector<std::filesystem::path>& files() const { return files_; }

 private:
  const std::optional<std::filesystem::path> place_;
  std::vector<std::filesystem::path> files_;
};

// Text form: an absolute path on each line. Other lines, and those beyond kMaxFiles, are left out.
std::vector<std::filesystem::path> parse_recent_files(std::string_view text);
std::string recent_files_text(const std::vector<std::filesystem::path>& files);

}  // namespace fire3dv::app
