#include "adapters/ros2/robot/conversion.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <utility>

#include "base/files.h"
#include "base/process/converter_process.h"

namespace fire3dv::ros2 {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxOutputBytes = uint64_t{1} << 30;
constexpr uint64_t kMaxLogBytes = uint64_t{1} << 20;

// File descriptor that is closed at the end of its scope.
struct Descriptor {
  explicit Descriptor(int opened) : fd(opened) {}
  Descriptor(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
  int fd;
};

Result<fs::path> make_folder() {
  const char* parent_folder = std::getenv("XDG_RUNTIME_DIR");
  if (!parent_folder || ::access(parent_folder, W_OK) != 0) parent_folder = std::getenv("TMPDIR");
  std::string name = (parent_folder ? std::string(parent_folder) : "/tmp") + "/fire3dv-ros2-XXXXXX";
  if (!::mkdtemp(name.data())) return Error{"cannot create " + name + ": " + system_reason(errno)};
  return fs::path(name);
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
  std::vector<std::string> arguments = {file.string(), "--confined", "-o", (*folder / "robot.glb").string()};
  for (const std::string& package : package_folders)
    arguments.insert(arguments.end(), {"--package-path", fs::absolute(package).string()});
  // 3 and above, also where this program was started without standard streams.
  const Descriptor nowhere(::open("/dev/null", O_WRONLY | O_CLOEXEC));
  const Descriptor log(::open((*folder / "log").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  const Descriptor output(::fcntl(nowhere.fd, F_DUPFD_CLOEXEC, 3)),
      messages(::fcntl(log.fd, F_DUPFD_CLOEXEC, 3));
  if (output.fd < 0 || messages.fd < 0)
    return Error{"cannot write to " + folder->string() + ": " + system_reason(errno)};
  const Result<pid_t> child = start_converter(arguments, output.fd, messages.fd, kMaxOutputBytes);
  if (!child) return Error{topic + ": " + child.error().message};
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
    if (std::chrono::steady_clock::now() - begun_ <= kLongestConversion) return std::nullopt;
    return Error{topic_ + ": its conversion takes longer than " + std::to_string(kLongestConversion.count()) +
                 " minutes"};
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
  ConverterMessages messages;
  if (const Result<FileBytes> log = read_file(folder_ / "log", kMaxLogBytes))
    messages.add(reinterpret_cast<const char*>(log->data.get()), log->size);
  messages.finish();
  if (const Result<void> good = converter_result(status, messages); !good)
    return Error{topic_ + ": " + in_words(good.error().message)};
  ConvertedRobot robot;
  for (std::string& warning : messages.take_warnings())
    robot.warnings.push_back(in_words(std::move(warning)));
  Result<std::vector<uint8_t>> glb = read_whole_file(folder_ / "robot.glb", kMaxOutputBytes);
  if (!glb) return Error{in_words(glb.error().message)};
  robot.glb = std::move(*glb);
  return robot;
}

}  // namespace fire3dv::ros2
