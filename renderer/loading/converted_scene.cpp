#include "renderer/loading/converted_scene.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "base/digest.h"
#include "base/files.h"
#include "base/process/converter_process.h"
#include "renderer/scene/cache_files.h"
#include "renderer/scene/files.h"
#include "renderer/scene/gltf/foreign_file.h"

namespace fire3dv::app {
namespace {

struct ConverterRun {
  std::vector<std::string> arguments;  // without the program's name
  int standard_output = -1;            // file descriptor for its standard output; -1: none
  // Polled ten times a second; true ends the converter.
  std::function<bool()> should_stop;
};

constexpr uint64_t kMaxOutputBytes = uint64_t{4} << 30;
constexpr int kPollMs = 100;
constexpr const char* kStopped = "it was interrupted";

class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  // Duplicate above the three standard descriptors, which the child replaces.
  static Descriptor beyond_standard(int fd) { return Descriptor(::fcntl(fd, F_DUPFD_CLOEXEC, 3)); }
  ~Descriptor() { reset(); }
  void reset() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

using Clock = std::chrono::steady_clock;

// Reason to end the converter, or nothing.
std::optional<std::string> why_end(const ConverterRun& wanted, Clock::time_point until) {
  if (wanted.should_stop && wanted.should_stop()) return kStopped;
  if (Clock::now() > until)
    return "it takes longer than " + std::to_string(kLongestConversion.count()) + " minutes";
  return std::nullopt;
}

// Reads until the child closes its standard error. Returns the reason to end it, or nothing.
std::optional<std::string> listen_to(int from, const ConverterRun& wanted, Clock::time_point until,
                                     ConverterMessages& messages) {
  char bytes[4096];
  while (true) {
    pollfd ready{from, POLLIN, 0};
    if (::poll(&ready, 1, kPollMs) > 0) {
      const ssize_t got = ::read(from, bytes, sizeof bytes);
      if (got == 0 || (got < 0 && errno != EINTR && errno != EAGAIN)) return std::nullopt;
      if (got > 0) messages.add(bytes, static_cast<size_t>(got));
    }
    if (std::optional<std::string> why = why_end(wanted, until)) return why;
  }
}

// Exit status after normal end or termination; `ended`: reason of the termination.
int wait_for(pid_t child, const ConverterRun& wanted, Clock::time_point until,
             std::optional<std::string>& ended) {
  int status = 0;
  while (true) {
    if (!ended) ended = why_end(wanted, until);
    if (ended) ::kill(child, SIGKILL);
    const pid_t got = ::waitpid(child, &status, ended ? 0 : WNOHANG);
    if (got == child || (got < 0 && errno != EINTR)) return status;
    if (got == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

// Runs the converter to its end. Returns its warnings, or its error message. Uses neither PATH nor a shell.
Result<std::vector<std::string>> run_converter(const ConverterRun& wanted) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return Error{std::string("cannot make a pipe: ") + std::strerror(errno)};
  const Descriptor reading(ends[0]);
  Descriptor low_writing(ends[1]);
  // If fire3dv was started with a closed standard stream, new descriptors reuse its number.
  Descriptor writing = Descriptor::beyond_standard(low_writing.get());
  low_writing.reset();
  Descriptor output =
      Descriptor::beyond_standard(wanted.standard_output >= 0 ? wanted.standard_output : writing.get());
  if (writing.get() < 0 || output.get() < 0)
    return Error{std::string("cannot start fire3dv-convert: ") + std::strerror(errno)};
  const Result<pid_t> child = start_converter(wanted.arguments, output.get(), writing.get(), kMaxOutputBytes);
  writing.reset();
  output.reset();  // may also be the pipe's
  if (!child) return child.error();

  ConverterMessages messages;
  const Clock::time_point until = Clock::now() + kLongestConversion;
  std::optional<std::string> ended = listen_to(reading.get(), wanted, until, messages);
  // A terminal interrupt reaches both processes and may have ended the converter already.
  const int status = wait_for(*child, wanted, until, ended);
  messages.finish();
  if (ended) return Error{"the conversion was ended: " + *ended};
  if (const Result<void> good = converter_result(status, messages); !good) return good.error();
  return messages.take_warnings();
}

// --- cache of conversions ---

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
  for (const std::string& argument : options.xacro_arguments) words.push_back("--xacro-arg=" + argument);
  if (!options.up.empty()) words.push_back("--up=" + options.up);
  for (const auto& [name, value] : {std::pair("--unit=", &options.unit),
                                    {"--dae-up=", &options.dae_up},
                                    {"--gltf-up=", &options.gltf_up},
                                    {"--smooth-angle=", &options.smooth_angle}})
    if (!value->empty()) words.push_back(name + *value);
  if (options.is_confined) words.emplace_back("--confined");
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

// Without the converter itself.
std::vector<fs::path> sources_of(const scene::ConversionRecord& record) {
  std::vector<fs::path> files;
  for (size_t i = 1; i < record.sources.size(); ++i) files.push_back(record.sources[i].file);
  return files;
}

// Nothing if caching is off or impossible.
std::optional<CachePaths> cache_paths(const fs::path& description, std::vector<std::string> words,
                                      const scene::SceneCacheSettings& cache) {
  // They decide about URDF's packages and SDF's models.
  for (const char* variable : {"ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "GZ_SIM_RESOURCE_PATH",
                               "IGN_GAZEBO_RESOURCE_PATH", "SDF_PATH", "GAZEBO_MODEL_PATH",
                               "GAZEBO_RESOURCE_PATH", "GZ_FUEL_CACHE_PATH", "IGN_FUEL_CACHE_PATH"}) {
    const char* value = std::getenv(variable);
    if (value && *value) words.push_back(std::string(variable) + "=" + value);
  }
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

bool needs_conversion(const fs::path& file) {
  constexpr std::string_view kEndings[] = {".yaml",  ".yml", ".urdf", ".xml", ".xacro", ".mjcf", ".sdf",
                                           ".world", ".obj", ".stl",  ".ply", ".dae",   ".3mf"};
  std::error_code error;
  if (fs::is_directory(file, error)) return fs::exists(file / "model.config", error);
  const std::string ending = lower_extension(file);
  return std::find(std::begin(kEndings), std::end(kEndings), ending) != std::end(kEndings) &&
         !scene::is_binary_gltf(file);
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
      converted.sources_ = sources_of(*record);
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
  if (const Result<scene::ConversionRecord> record = scene::read_conversion_record(paths->record); record)
    converted.sources_ = sources_of(*record);
  if (cache.place == Place::folder) {
    scene::remove_oldest(cache.folder, kScene, cache.max_bytes);
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
      sources_(std::move(other.sources_)),
      is_cached_(other.is_cached_),
      memory_(std::exchange(other.memory_, -1)) {}

ConvertedScene::~ConvertedScene() {
  if (memory_ >= 0) ::close(memory_);
}

}  // namespace fire3dv::app
