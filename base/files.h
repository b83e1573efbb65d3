// Whole files. They are replaced atomically: a name refers to the complete old contents or to the complete
// new contents, also after a power cut. They are read with a limit on their size; a pipe, a device or a file
// that shrinks while it is read is an error. Errors name the file.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/text.h"

namespace fire3dv::base {

// State of the disk when AtomicFile::commit() returns.
enum class Durability {
  contents,           // the contents were flushed before the rename; a power cut may still undo the rename
  contents_and_name,  // the folder was flushed, too: the new file survives a power cut
};

struct AtomicFileOptions {
  mode_t mode = 0666;                // reduced by the umask
  std::optional<mode_t> exact_mode;  // set as given, regardless of the umask
  bool replaces = true;              // false: commit() fails if the name exists
  Durability durability = Durability::contents_and_name;
};

// Name pattern of temporary files: PATH.part-XXXXXX with six random letters. Writers of one path never share
// one.
inline constexpr std::string_view kTemporaryMark = ".part-";

class AtomicFile {
 public:
  static Result<AtomicFile> create(const std::filesystem::path& path, const AtomicFileOptions& options = {});
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();  // removes the temporary file unless commit() succeeded

  Result<void> append(std::span<const std::byte> bytes);
  Result<void> truncate(uint64_t length);
  // Flushes the contents to the disk, renames the file, and flushes the folder. append() is invalid
  // afterwards.
  Result<void> commit();
  // Path for libraries that open files by name. They must close the file before commit().
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

// Removes the temporary files that killed writers left behind: those with a name that begins with `prefix`.
void remove_abandoned_temporaries(const std::filesystem::path& folder, std::string_view prefix);

// Flushes one open file. Returns 0 or the error number. File systems without flush count as flushed.
enum class Flush { data, data_and_metadata };
int flush(int fd, Flush what);
// Flushes one file by name. Same result as flush().
int flush_file(const std::filesystem::path& path);
// Flushes the entries of the folder that holds `path`. Returns 0 or the error number; best effort if the
// folder cannot be opened.
int flush_folder_of(const std::filesystem::path& path);

// Creates a folder and its parents. An existing folder is no error.
Result<void> create_folder(const std::filesystem::path& folder);

// Text of an error number, with a remedy for the common ones.
std::string system_reason(int error_number);

}  // namespace fire3dv::base

namespace fire3dv {

// Contents of a file, in memory that is not cleared before: assets may hold gigabytes.
struct FileBytes {
  std::unique_ptr<std::byte[]> data;
  size_t size = 0;
  std::span<const std::byte> view() const { return {data.get(), size}; }
};

// A regular file, for reading, on any number of threads at once.
class OpenFile {
 public:
  static Result<OpenFile> open(const std::filesystem::path& path, uint64_t max_bytes);
  OpenFile(OpenFile&& other) noexcept;
  ~OpenFile();
  OpenFile& operator=(const OpenFile&) = delete;

  uint64_t size() const { return size_; }
  // False when the file does not have them, or not any more; errno is 0 then.
  bool read(uint64_t offset, std::span<std::byte> to) const;

 private:
  OpenFile() = default;
  int fd_ = -1;
  uint64_t size_ = 0;
};

// Regular files only: a pipe or a device would block or never end.
Result<FileBytes> read_file(const std::filesystem::path& path, uint64_t max_bytes);

// Replaces the file atomically; a failure leaves no new file.
Result<void> write_whole_file(const std::filesystem::path& path, std::span<const uint8_t> bytes,
                              base::Durability durability = base::Durability::contents_and_name);

Result<std::vector<uint8_t>> read_whole_file(const std::filesystem::path& path, uint64_t max_bytes);

using base::system_reason;

// Extension in lower case, with its dot: ".glb".
inline std::string lower_extension(const std::filesystem::path& path) {
  return lower_case(path.extension().string());
}

}  // namespace fire3dv
