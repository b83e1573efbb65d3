#include "renderer/scene/cache/file_stamp.h"

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <istream>
#include <ostream>

namespace fire3dv::scene {
namespace {

constexpr int64_t kTick_ns = 20'000'000;  // upper bound for most file systems' clocks

int64_t nanoseconds(const timespec& time) {
  return int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

bool FileStamp::is_settled_at(int64_t time_ns) const {
  return std::max(modified_ns, changed_ns) + kTick_ns < time_ns;
}

FileStamp stamp_of(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return {};
  return {true, static_cast<uint64_t>(status.st_size), status.st_ino, nanoseconds(status.st_mtim),
          nanoseconds(status.st_ctim)};
}

Result<StampedDigest> stamped_digest_of(const std::filesystem::path& file, uint64_t max_bytes) {
  StampedDigest stamped;
  stamped.taken_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                         std::chrono::system_clock::now().time_since_epoch())
                         .count();
  stamped.stamp = stamp_of(file);
  const Result<Digest> digest = digest_of_file(file, max_bytes);
  if (!digest) return digest.error();
  stamped.digest = *digest;
  return stamped;
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\n')
      result += "\\n";
    else if (c == '\\')
      result += "\\\\";
    else
      result += c;
  }
  return result;
}

std::string unescaped(const std::string& text) {
  std::string result;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 1 < text.size())
      result += text[++i] == 'n' ? '\n' : text[i];
    else
      result += text[i];
  }
  return result;
}

void write(std::ostream& out, const FileStamp& stamp) {
  out << stamp.exists << ' ' << stamp.size << ' ' << stamp.inode << ' ' << stamp.modified_ns << ' '
      << stamp.changed_ns;
}

bool read(std::istream& in, FileStamp& stamp) {
  return static_cast<bool>(in >> stamp.exists >> stamp.size >> stamp.inode >> stamp.modified_ns >>
                           stamp.changed_ns);
}

}  // namespace fire3dv::scene
