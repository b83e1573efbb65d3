#include "renderer/scene/cache/digest_cache.h"

#include <charconv>
#include <sstream>
#include <utility>

#include "renderer/scene/cache/cache_files.h"
#include "renderer/scene/cache/file_stamp.h"
#include "renderer/scene/files.h"

namespace fire3dv::scene {
namespace {

constexpr std::string_view kFirstLine = "fire3dv digests 1", kEnding = ".digests";
constexpr uint64_t kMaxBytes = 16 << 20;  // per record, and of all records

std::string absolute_name(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::absolute(file, error);
  return (error ? file : path).lexically_normal().string();
}

bool read(std::istream& in, Digest& digest) {
  std::string text;
  if (!(in >> text) || text.size() != 2 * digest.size()) return false;
  for (size_t i = 0; i < digest.size(); ++i) {
    const char* const end = text.data() + 2 * i + 2;
    if (std::from_chars(end - 2, end, digest[i], 16).ptr != end) return false;
  }
  return true;
}

std::string end_line(std::string_view text) {
  Checksum checksum;
  checksum.add(std::as_bytes(std::span(text)));
  return "end " + std::to_string(checksum.value()) + "\n";
}

// Returns a complete record without its last line (the checksum), else an empty string.
std::string read_whole(const std::filesystem::path& file) {
  const Result<FileBytes> bytes = read_file(file, kMaxBytes);
  if (!bytes) return {};
  const std::string_view text(reinterpret_cast<const char*>(bytes->data.get()), bytes->size);
  const size_t end = text.rfind("end ");
  if (end == std::string_view::npos || text.substr(end) != end_line(text.substr(0, end))) return {};
  return std::string(text.substr(0, end));
}

// Returns all digests of a valid record, else none.
std::map<std::string, StampedDigest> read_record(const std::filesystem::path& file,
                                                 const std::string& asset) {
  std::istringstream lines(read_whole(file));
  std::string text;
  if (!std::getline(lines, text) || text != kFirstLine) return {};
  if (!std::getline(lines, text) || unescaped(text) != asset) return {};
  std::map<std::string, StampedDigest> digests;
  while (std::getline(lines, text)) {
    std::istringstream line(text);
    StampedDigest entry;
    std::string name;
    if (!read(line, entry.stamp) || !(line >> entry.taken_ns) || entry.taken_ns <= 0 ||
        !read(line, entry.digest) || line.get() != ' ' || !std::getline(line, name))
      return {};
    digests[unescaped(name)] = entry;
  }
  return digests;
}

}  // namespace

DigestCache::DigestCache(const std::filesystem::path& folder, const std::filesystem::path& asset)
    : asset_(absolute_name(asset)) {
  const Digest name = digest_of(std::as_bytes(std::span(asset_)));
  record_ = folder / (hex(std::span(name).first(16)) + std::string(kEnding));
  digests_ = read_record(record_, asset_);
}

Result<StampedDigest> DigestCache::of(const std::filesystem::path& file, uint64_t max_bytes) {
  if (record_.empty()) return stamped_digest_of(file, max_bytes);
  const std::string name = absolute_name(file);
  const auto entry = digests_.find(name);
  if (entry != digests_.end() && entry->second.stamp.size <= max_bytes && entry->second.holds(file))
    return entry->second;
  Result<StampedDigest> digest = stamped_digest_of(file, max_bytes);
  if (!digest) return digest;
  digests_[name] = *digest;
  has_new_ = true;
  return digest;
}

void DigestCache::store() {
  if (record_.empty()) return;
  if (!std::exchange(has_new_, false)) return touch(record_);
  std::ostringstream out;
  out << kFirstLine << '\n' << escaped(asset_) << '\n';
  for (const auto& [name, entry] : digests_) {
    write(out, entry.stamp);
    out << ' ' << entry.taken_ns << ' ' << hex(entry.digest) << ' ' << escaped(name) << '\n';
  }
  std::string text = std::move(out).str();
  text += end_line(text);
  (void)write_cache_file(record_, {std::as_bytes(std::span(text))});
  remove_oldest(record_.parent_path(), kEnding, kMaxBytes);
}

}  // namespace fire3dv::scene
