// File access of the MJCF reader: names are resolved as in MuJoCo, and only regular files are opened. Files
// of a confined model lie below its folder and those that the user named.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "convert/description_files.h"
#include "convert/model.h"

namespace fire3dv::convert {

// Warnings of one conversion. Messages beyond the limit are counted instead of stored, so that a file cannot
// fill the memory with them.
class MjcfMessages {
 public:
  explicit MjcfMessages(std::vector<std::string>& warnings) : warnings_(warnings) {}
  ~MjcfMessages();
  MjcfMessages(const MjcfMessages&) = delete;
  MjcfMessages& operator=(const MjcfMessages&) = delete;

  // Equal messages are stored once.
  void warn(std::string message);

 private:
  std::vector<std::string>& warnings_;
  size_t stored_ = 0, left_out_ = 0;
};

class MjcfFiles {
 public:
  // sources: receives every path that is tried.
  // is_confined: files must lie below the model's folder or one of `folders`.
  MjcfFiles(const std::filesystem::path& model, const std::vector<std::filesystem::path>& folders,
            bool is_confined, Sources& sources);

  // Returns the first existing regular file: an absolute name itself, otherwise the name below each folder.
  // Backslashes separate folders. The error names the file and says why it is refused.
  Result<std::filesystem::path> find(std::string name, const std::vector<std::filesystem::path>& folders);

  // Reads a file that find() returned, of at most 256 MiB.
  Result<FileBytes> read(const std::filesystem::path& file) const;

 private:
  bool may_read(const std::filesystem::path& resolved) const {
    return !is_confined_ || allowed_.hold(resolved);
  }

  AllowedFolders allowed_;
  const bool is_confined_;
  Sources& sources_;
};

}  // namespace fire3dv::convert
