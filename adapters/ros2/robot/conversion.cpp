#include "adapters/ros2/robot/conversion.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <utility>

#include "protocol/base/files.h"

namespace fire3dv::ros2 {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::minutes kLongest{15};
constexpr uint64_t kMaxMemoryBytes = uint64_t{16} << 30, kMaxOutputBytes = uint64_t{1} << 30;
constexpr uint64_t kMaxLogBytes = uint64_t{1} << 20;
constexpr size_t kMaxWarnings = 30;

fs::path converter_file() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path() / "fire3dv-convert";
}

Result<fs::path> make_folder() {
  const char* place = std::getenv("XDG_RUNTIME_DIR");
  if (!place || ::access(place, W_OK) != 0) place = std::getenv("TMPDIR");
  std::string name = (place ? std::string(place) : "/tmp") + "/fire3dv-ros2-XXXXXX";
  if (!::mkdtemp(name.data())) return Error{"cannot create " + name + ": " + system_reason(errno)};
  return fs::path(name);
}

void lower_limit(pid_t child, __rlimit_resource resource, rlim_t most) {
  rlimit limit{};
  if (::prlimit(child, resource, nullptr, &limit) != 0) return;
  limit.rlim_max = std::min(limit.rlim_max, most);
  limit.rlim_cur = std::min(limit.rlim_cur, limit.rlim_max);
  ::prlimit(child, resource, &limit, nullptr);
}

Result<pid_t> spawn(const fs::path& program, const std::vector<std::string>& arguments, const fs::path& log) {
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&files);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t pid = 0;
  const int fault = posix_spawn(&pid, program.c_str(), &files, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (fault != 0)
    return Error{"the robot description needs " + program.string() + ", which cannot be started: " +
                 std::strerror(fault)};
  lower_limit(pid, RLIMIT_CORE, 0);
  lower_limit(pid, RLIMIT_FSIZE, kMaxOutputBytes);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they reserve terabytes
  lower_limit(pid, RLIMIT_AS, kMaxMemoryBytes);
#endif
  return pid;
}

}  // namespace

Result<Conversion> Conversion::start(const std::string& urdf, const std::vector<std::string>& package_folders,
                                     const std::string& topic) {
  Result<fs::path> folder = make_folder();
  if (!folder) return folder.error();
  Conversion conversion(*folder, topic);
  const fs::path file = *folder / "robot.urdf";
  const std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(urdf.data()), urdf.size());
  if (Result<void> written = write_whole_file(file, bytes, base::Durability::contents); !written)
    return written.error();
  std::vector<std::string> arguments = {file.string(), "-o", (*folder / "robot.glb").string()};
  for (const std::string& package : package_folders)
    arguments.insert(arguments.end(), {"--package-path", fs::absolute(package).string()});
  const Result<pid_t> child = spawn(converter_file(), arguments, *folder / "log");
  if (!child) return child.error();
  conversion.child_ = *child;
  conversion.begun_ = std::chrono::steady_clock::now();
  return conversion;
}

Conversion::Conversion(Conversion&& other) noexcept
    : folder_(std::exchange(other.folder_, {})),
      topic_(std::move(other.topic_)),
      child_(std::exchange(other.child_, 0)),
      begun_(other.begun_) {}

Conversion& Conversion::operator=(Conversion&& other) noexcept {
  std::swap(folder_, other.folder_);
  std::swap(topic_, other.topic_);
  std::swap(child_, other.child_);
  std::swap(begun_, other.begun_);
  return *this;
}

Conversion::~Conversion() {
  if (child_ > 0) {
    ::kill(child_, SIGKILL);
    while (::waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  std::error_code error;
  if (!folder_.empty()) fs::remove_all(folder_, error);
}

std::optional<Result<ConvertedRobot>> Conversion::poll() {
  int status = 0;
  const pid_t got = ::waitpid(child_, &status, WNOHANG);
  if (got == 0) {
    if (std::chrono::steady_clock::now() - begun_ <= kLongest) return std::nullopt;
    return Error{topic_ + ": its conversion takes longer than 15 minutes"};
  }
  if (got < 0 && errno == EINTR) return std::nullopt;
  child_ = 0;
  return finish(status);
}

std::string Conversion::in_words(std::string text) const {
  const std::string file = (folder_ / "robot.urdf").string();
  for (size_t at = 0; (at = text.find(file, at)) != text.npos; at += topic_.size())
    text.replace(at, file.size(), topic_);
  return text;
}

Result<ConvertedRobot> Conversion::finish(int status) const {
  ConvertedRobot robot;
  std::string last;
  if (const Result<FileBytes> log = read_file(folder_ / "log", kMaxLogBytes)) {
    std::istringstream lines(std::string(reinterpret_cast<const char*>(log->data.get()), log->size));
    for (std::string line; std::getline(lines, line);) {
      for (const std::string_view start : {"fire3dv-convert: ", "error: ", "info: "})
        if (line.starts_with(start)) line.erase(0, start.size());
      line = in_words(std::move(line));
      if (constexpr std::string_view kWarning = "warning: "; line.starts_with(kWarning)) {
        if (robot.warnings.size() < kMaxWarnings) robot.warnings.push_back(line.substr(kWarning.size()));
      } else if (!line.empty()) {
        last = line;
      }
    }
  }
  if (WIFSIGNALED(status))
    return Error{topic_ + ": fire3dv-convert crashed (" + strsignal(WTERMSIG(status)) + ")"};
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return Error{last.empty() ? topic_ + " cannot be converted" : last};
  Result<std::vector<uint8_t>> glb = read_whole_file(folder_ / "robot.glb", kMaxOutputBytes);
  if (!glb) return Error{in_words(glb.error().message)};
  robot.glb = std::move(*glb);
  return robot;
}

}  // namespace fire3dv::ros2
