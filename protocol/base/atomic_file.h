// Atomic replacement of files: a name leads to the complete old contents or to the complete new ones, also
// after a power cut. Errors name the file.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::base {

// State of the disk when AtomicFile::commit() returns.
enum class Durability {
  contents,           // the contents were flushed before the rename; a power cut may still undo the rename
  contents_and_name,  // the folder was flushed, too: the new file survives a power cut
};

struct AtomicFileOptions {
  mode_t mode = 0666;                // less the umask
  std::optional<mode_t> exact_mode;  // set as it is, whatever the umask
  bool replaces = true;              // false: commit() fails if the name exists
  Durability durability = Durability::contents_and_name;
};

// Temporary files are called PATH.part-XXXXXX, with six random letters: writers of one path never share one.
inline constexpr std::string_view kTemporaryMark = ".part-";

class AtomicFile {
 public:
  static Result<AtomicFile> create(const std::filesystem::path& path, const AtomicFileOptions& options = {});
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();  // removes the temporary file unless commit() succeeded

  Result<void> append(std::span<const std::byte> bytes);
  Result<void> truncate(uint64_t length);
  // Flushes the contents to the disk, renames the file, and flushes the folder. No append() afterwards.
  Result<void> commit();
  // For libraries that open files by name. They close theirs before commit().
  const std::string& temporary_path() const { return temporary_; }

 private:
  AtomicFile(std::string path, std::string temporary, int fd, const AtomicFileOptions& options);
  Error cannot_write(int error_number) const;

  std::string path_, temporary_;
  int fd_;
  AtomicFileOptions options_;
  bool is_committed_ = false;
};

Result<void> write_atomically(const std::filesystem::path& path,
                              const std::vector<std::span<const std::byte>>& pieces,
                              const AtomicFileOptions& options = {});

// Removes the temporary files of writers that were killed: those of names that begin with `prefix`.
void remove_abandoned_temporaries(const std::filesystem::path& folder, std::string_view prefix);

// Flushes one open file. 0, or the error number. File systems that cannot flush count as flushed.
enum class Flush { data, data_and_metadata };
int flush(int fd, Flush what);
// The same for a file by its name.
int flush_file(const std::filesystem::path& path);
// Flushes the entries of the folder that holds `path`. 0, or the error number. Best effort where it cannot be
// opened.
int flush_folder_of(const std::filesystem::path& path);

// Text of an error number, and the remedy where there is one.
std::string system_reason(int error_number);

}  // namespace fire3dv::base
