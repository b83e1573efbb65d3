#include "renderer/app/loading/converted_scene.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "protocol/base/digest.h"
#include "renderer/app/loading/run_converter.h"
#include "renderer/scene/cache/cache_files.h"
#include "renderer/scene/cache/conversion_record.h"
#include "renderer/scene/files.h"

namespace fire3dv::app {
namespace {

namespace fs = std::filesystem;
using Place = scene::SceneCacheSettings::Place;
constexpr std::string_view kScene = ".converted.glb", kRecord = ".conversion";
constexpr uint64_t kMaxRecordBytes = uint64_t{64} << 20;

std::vector<std::string> arguments_of(const ConvertOptions& options) {
  std::vector<std::string> words;
  if (options.models == "all")
    words.emplace_back("--all");
  else if (!options.models.empty())
    words.insert(words.end(), {"-l", options.models});
  if (!options.name_space.empty()) words.push_back("--ns=" + options.name_space);
  for (const fs::path& folder : options.package_folders)
    words.insert(words.end(), {"--package-path", fs::absolute(folder).string()});
  return words;
}

std::string key_of(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += word + '\0';
  const Digest digest = digest_of(std::as_bytes(std::span(text)));
  return hex(std::span(digest).first(16));
}

struct CachePaths {
  fs::path scene, record;
};

// True if this converter wrote the cache entry: another version may produce other output. The converter is
// the first recorded source.
bool is_by(const fs::path& converter, const scene::ConversionRecord& record) {
  std::error_code error;
  return !record.sources.empty() && record.sources.front().file == fs::canonical(converter, error) && !error;
}

// Nothing if caching is off or impossible.
std::optional<CachePaths> cache_paths(const fs::path& description, std::vector<std::string> words,
                                      const scene::SceneCacheSettings& cache) {
  std::string stem;
  if (cache.place == Place::beside_the_asset) {
    stem = description.string() + ".fire3dv-cache" + (words.empty() ? "" : "." + key_of(words));
  } else if (cache.place == Place::folder) {
    words.push_back(description.string());
    stem = (cache.folder / key_of(words)).string();
  } else {
    return std::nullopt;
  }
  const fs::path folder = fs::path(stem).parent_path();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || ::access(folder.c_str(), W_OK) != 0) return std::nullopt;
  return CachePaths{stem + std::string(kScene), stem + std::string(kRecord)};
}

}  // namespace

bool is_description(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".yaml" || ending == ".yml" || ending == ".urdf" || ending == ".xml" || ending == ".xacro";
}

Result<ConvertedScene> ConvertedScene::open(const fs::path& description, const ConvertOptions& options,
                                            const scene::SceneCacheSettings& cache,
                                            const std::function<bool()>& should_stop) {
  std::error_code error;
  const fs::path file = fs::canonical(description, error);
  if (error) return Error{"cannot open " + quote(description.string()) + ": " + error.message()};
  std::vector<std::string> words = arguments_of(options);
  const Result<std::string> converter = converter_file();
  if (!converter) return converter.error();
  const std::optional<CachePaths> paths = cache_paths(file, words, cache);
  ConvertedScene converted;
  if (paths) {
    converted.file_ = paths->scene;
    Result<scene::ConversionRecord> record = scene::read_conversion_record(paths->record);
    if (record && is_by(*converter, *record) && scene::holds(*record, paths->scene)) {
      converted.warnings_ = std::move(record->warnings);
      converted.is_cached_ = true;
      return converted;
    }
  } else {
    if (Result<void> done = converted.convert_into_memory(std::move(words), file, should_stop); !done)
      return done.error();
    return converted;
  }
  std::vector<std::string> keeping = words;
  keeping.insert(keeping.end(),
                 {file.string(), "-o", paths->scene.string(), "--sources", paths->record.string()});
  Result<std::vector<std::string>> done = run_converter({std::move(keeping), -1, should_stop});
  if (!done) {
    // A full disk must not prevent display; only for write errors does the converter report "cannot write".
    if (!done.error().message.starts_with("cannot write ")) return done.error();
    if (Result<void> again = converted.convert_into_memory(std::move(words), file, should_stop); !again)
      return again.error();
    converted.warnings_.push_back("it is not cached for the next start: " + done.error().message);
    return converted;
  }
  converted.warnings_ = std::move(*done);
  if (cache.place == Place::folder) {
    scene::remove_oldest(cache.folder, kScene, cache.most_bytes);
    scene::remove_oldest(cache.folder, kRecord, kMaxRecordBytes);
  }
  return converted;
}

Result<void> ConvertedScene::convert_into_memory(std::vector<std::string> words, const fs::path& description,
                                                 const std::function<bool()>& should_stop) {
  memory_ = ::memfd_create("fire3dv scene", MFD_CLOEXEC);
  if (memory_ < 0) return Error{std::string("no memory for a scene: ") + std::strerror(errno)};
  file_ = "/proc/self/fd/" + std::to_string(memory_);
  words.insert(words.end(), {description.string(), "-o", "-"});
  Result<std::vector<std::string>> done = run_converter({std::move(words), memory_, should_stop});
  if (!done) return done.error();
  warnings_ = std::move(*done);
  return {};
}

ConvertedScene::ConvertedScene(ConvertedScene&& other) noexcept
    : file_(std::move(other.file_)),
      warnings_(std::move(other.warnings_)),
      is_cached_(other.is_cached_),
      memory_(std::exchange(other.memory_, -1)) {}

ConvertedScene::~ConvertedScene() {
  if (memory_ >= 0) ::close(memory_);
}

}  // namespace fire3dv::app
