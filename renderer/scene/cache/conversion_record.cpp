#include "renderer/scene/cache/conversion_record.h"

#include <algorithm>
#include <sstream>

#include "renderer/scene/cache/file_stamp.h"
#include "renderer/scene/files.h"

namespace fire3dv::scene {
namespace {

constexpr std::string_view kFirstLine = "fire3dv conversion 1";
constexpr uint64_t kMaxBytes = uint64_t{256} << 20;

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
  out << kFirstLine << "\nresult ";
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
  const Result<FileBytes> bytes = read_file(file, kMaxBytes);
  if (!bytes) return bytes.error();
  std::istringstream lines(std::string(reinterpret_cast<const char*>(bytes->data.get()), bytes->size));
  std::string text;
  const Error damaged{quote(file.string()) + " is no record of a conversion"};
  if (!std::getline(lines, text) || text != kFirstLine) return damaged;
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

}  // namespace fire3dv::scene
