#include "renderer/scene/cache_files.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <istream>
#include <ostream>
#include <sstream>
#include <system_error>
#include <utility>

#include "base/files.h"
#include "renderer/scene/files.h"

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

namespace {

constexpr std::string_view kConversionFirstLine = "fire3dv conversion 1";
constexpr uint64_t kMaxConversionBytes = uint64_t{256} << 20;

// Ignores the change time, which hard links modify; the file is always replaced as a whole.
bool same_result(FileStamp a, FileStamp b) {
  a.changed_ns = b.changed_ns = 0;
  return a == b;
}

}  // namespace

ConversionRecord record_of(const std::filesystem::path& result,
                           const std::vector<ConversionRecord::Source>& sources, int64_t begun_ns) {
  ConversionRecord record;
  record.result = stamp_of(result);
  for (ConversionRecord::Source source : sources) {
    if (!source.stamp.is_settled_at(begun_ns)) source.stamp.inode = 0;  // matches no file
    source.file = std::filesystem::absolute(source.file);
    record.sources.push_back(std::move(source));
  }
  return record;
}

std::string text_of(const ConversionRecord& record) {
  std::ostringstream out;
  out << kConversionFirstLine << "\nresult ";
  write(out, record.result);
  out << '\n';
  for (const ConversionRecord::Source& source : record.sources) {
    out << "source ";
    write(out, source.stamp);
    out << ' ' << escaped(source.file.string()) << '\n';
  }
  for (const std::string& warning : record.warnings) out << "warning " << escaped(warning) << '\n';
  out << "end\n";
  return std::move(out).str();
}

Result<ConversionRecord> read_conversion_record(const std::filesystem::path& file) {
  const Result<FileBytes> bytes = read_file(file, kMaxConversionBytes);
  if (!bytes) return bytes.error();
  std::istringstream lines(std::string(reinterpret_cast<const char*>(bytes->data.get()), bytes->size));
  std::string text;
  const Error damaged{quote(file.string()) + " is no record of a conversion"};
  if (!std::getline(lines, text) || text != kConversionFirstLine) return damaged;
  ConversionRecord record;
  while (std::getline(lines, text)) {
    std::istringstream line(text);
    std::string kind;
    line >> kind;
    if (kind == "end") return record;
    if (kind == "result") {
      if (!read(line, record.result)) return damaged;
    } else if (kind == "source") {
      ConversionRecord::Source source;
      if (!read(line, source.stamp) || line.get() != ' ') return damaged;
      std::string name;
      std::getline(line, name);
      source.file = unescaped(name);
      record.sources.push_back(std::move(source));
    } else if (kind == "warning") {
      record.warnings.push_back(unescaped(text.substr(std::min(text.size(), kind.size() + 1))));
    } else {
      return damaged;
    }
  }
  return damaged;  // truncated
}

bool holds(const ConversionRecord& record, const std::filesystem::path& result) {
  const FileStamp now = stamp_of(result);
  return now.exists && same_result(now, record.result) &&
         std::all_of(
             record.sources.begin(), record.sources.end(),
             [](const ConversionRecord::Source& source) { return stamp_of(source.file) == source.stamp; });
}

namespace {

constexpr std::string_view kDigestsFirstLine = "fire3dv digests 1", kDigestsEnding = ".digests";
constexpr uint64_t kMaxDigestsBytes = 16 << 20;  // per record, and of all records

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
std::string read_complete_record(const std::filesystem::path& file) {
  const Result<FileBytes> bytes = read_file(file, kMaxDigestsBytes);
  if (!bytes) return {};
  const std::string_view text(reinterpret_cast<const char*>(bytes->data.get()), bytes->size);
  const size_t end = text.rfind("end ");
  if (end == std::string_view::npos || text.substr(end) != end_line(text.substr(0, end))) return {};
  return std::string(text.substr(0, end));
}

// Returns all digests of a valid record, else none.
std::map<std::string, StampedDigest> read_record(const std::filesystem::path& file,
                                                 const std::string& asset) {
  std::istringstream lines(read_complete_record(file));
  std::string text;
  if (!std::getline(lines, text) || text != kDigestsFirstLine) return {};
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
  record_ = folder / (hex(std::span(name).first(16)) + std::string(kDigestsEnding));
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
  out << kDigestsFirstLine << '\n' << escaped(asset_) << '\n';
  for (const auto& [name, entry] : digests_) {
    write(out, entry.stamp);
    out << ' ' << entry.taken_ns << ' ' << hex(entry.digest) << ' ' << escaped(name) << '\n';
  }
  std::string text = std::move(out).str();
  text += end_line(text);
  (void)write_cache_file(record_, {std::as_bytes(std::span(text))});
  remove_oldest(record_.parent_path(), kDigestsEnding, kMaxDigestsBytes);
}

namespace {

constexpr std::chrono::hours kPartLifetime{1};

}  // namespace

Result<void> write_cache_file(const std::filesystem::path& path,
                              const std::vector<std::span<const std::byte>>& pieces) {
  return base::write_atomically(path, pieces, {.mode = 0600, .durability = base::Durability::contents});
}

void remove_oldest(const std::filesystem::path& folder, std::string_view ending, uint64_t max_bytes) {
  namespace fs = std::filesystem;
  struct Entry {
    fs::path path;
    fs::file_time_type used;
    uint64_t bytes;
  };
  std::vector<Entry> all;
  uint64_t bytes = 0;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code fault;
    const std::string name = entry->path().filename().string();
    if (entry->is_symlink(fault) || !entry->is_regular_file(fault)) continue;
    const auto used = entry->last_write_time(fault);
    const uint64_t size = fault ? 0 : entry->file_size(fault);
    if (fault) continue;
    const size_t mark = name.rfind(base::kTemporaryMark);
    if (mark != std::string::npos && name.substr(0, mark).ends_with(ending)) {
      if (fs::file_time_type::clock::now() - used > kPartLifetime) fs::remove(entry->path(), fault);
    } else if (name.ends_with(ending)) {
      all.push_back({entry->path(), used, size});
      bytes += size;
    }
  }
  std::sort(all.begin(), all.end(), [](const Entry& a, const Entry& b) { return a.used < b.used; });
  for (const Entry& entry : all) {
    if (bytes <= max_bytes) return;
    std::error_code fault;
    if (fs::remove(entry.path, fault)) bytes -= entry.bytes;
  }
}

void touch(const std::filesystem::path& path) {
  ::utimensat(AT_FDCWD, path.c_str(), nullptr, AT_SYMLINK_NOFOLLOW);
}

}  // namespace fire3dv::scene
