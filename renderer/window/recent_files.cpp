#include "renderer/window/recent_files.h"

#include <algorithm>
#include <cstdint>
#include <system_error>

#include "base/files.h"

namespace fire3dv::app {
namespace {

constexpr uint64_t kMaxBytes = 64 << 10;

}  // namespace

std::optional<std::filesystem::path> recent_files_path(
    const std::function<const char*(const char*)>& environment) {
  // The XDG specification requires that relative paths are ignored.
  const auto absolute = [&](const char* name) {
    const char* value = environment(name);
    return std::filesystem::path(value && *value == '/' ? value : "");
  };
  if (const auto state = absolute("XDG_STATE_HOME"); !state.empty()) return state / "fire3dv" / "recent";
  if (const auto home = absolute("HOME"); !home.empty())
    return home / ".local" / "state" / "fire3dv" / "recent";
  return std::nullopt;
}

std::vector<std::filesystem::path> parse_recent_files(std::string_view text) {
  std::vector<std::filesystem::path> files;
  while (!text.empty() && files.size() < RecentFiles::kMaxFiles) {
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const bool is_path = line.starts_with('/') && line.find('\0') == std::string_view::npos;
    if (is_path && std::find(files.begin(), files.end(), line) == files.end()) files.emplace_back(line);
  }
  return files;
}

std::string recent_files_text(const std::vector<std::filesystem::path>& files) {
  std::string text;
  for (const std::filesystem::path& file : files) text += file.string() + "\n";
  return text;
}

Result<void> RecentFiles::add(const std::filesystem::path& shown) {
  std::error_code error;
  const std::filesystem::path file = std::filesystem::absolute(shown, error).lexically_normal();
  if (error || file.string().find('\n') != std::string::npos) return {};
  files_.clear();
  if (place_) {
    if (const Result<std::vector<uint8_t>> bytes = read_whole_file(*place_, kMaxBytes))
      files_ = parse_recent_files({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
  }
  std::erase(files_, file);
  files_.insert(files_.begin(), file);
  if (files_.size() > kMaxFiles) files_.resize(kMaxFiles);
  if (!place_) return {};
  std::filesystem::create_directories(place_->parent_path(), error);
  if (error) return Error{place_->string() + ": its folder cannot be made: " + error.message()};
  const std::string text = recent_files_text(files_);
  return write_whole_file(*place_, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

}  // namespace fire3dv::app
