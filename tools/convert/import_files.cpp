#include "tools/convert/import_files.h"

#include <algorithm>
#include <cstring>
#include <optional>

#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr uint64_t kMostBytes = uint64_t{1} << 28;

class MemoryStream : public Assimp::IOStream {
 public:
  explicit MemoryStream(FileBytes bytes) : bytes_(std::move(bytes)) {}

  size_t Read(void* to, size_t size, size_t count) override {
    if (size == 0) return 0;
    count = std::min(count, (bytes_.size - at_) / size);
    if (count > 0) std::memcpy(to, bytes_.data.get() + at_, size * count);
    at_ += size * count;
    return count;
  }
  size_t Write(const void*, size_t, size_t) override { return 0; }
  aiReturn Seek(size_t offset, aiOrigin origin) override {
    const size_t from = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? at_ : bytes_.size;
    // Negative offsets arrive as large unsigned ones; the sum wraps as intended.
    const size_t to = from + offset;
    if (to > bytes_.size) return aiReturn_FAILURE;
    at_ = to;
    return aiReturn_SUCCESS;
  }
  size_t Tell() const override { return at_; }
  size_t FileSize() const override { return bytes_.size; }
  void Flush() override {}

 private:
  FileBytes bytes_;
  size_t at_ = 0;
};

}  // namespace

ImportFiles::ImportFiles(const std::filesystem::path& file, Sources& besides)
    : file_(file), besides_(besides) {
  folders_.add(file.parent_path());
}

bool ImportFiles::Exists(const char* name) const {
  if (file_ == name) return true;
  const Result<std::filesystem::path> found = regular_file(name);
  return found && folders_.hold(*found);
}

Assimp::IOStream* ImportFiles::Open(const char* name, const char* mode) {
  if (std::strpbrk(mode, "wa+")) return nullptr;
  if (file_ != name) {
    besides_.add(name);
    const Result<std::filesystem::path> found = regular_file(name);
    if (!found || !folders_.hold(*found)) return nullptr;
  }
  Result<FileBytes> bytes = read_file(name, kMostBytes);
  return bytes ? new MemoryStream(std::move(*bytes)) : nullptr;
}

}  // namespace fire3dv::convert
