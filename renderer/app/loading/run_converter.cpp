#include "renderer/app/loading/run_converter.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <optional>
#include <thread>

extern char** environ;

namespace fire3dv::app {
namespace {

constexpr std::chrono::minutes kLongest{15};
constexpr int kPollMs = 100;
constexpr size_t kMaxLineBytes = 4096, kMaxWarnings = 1000;
constexpr const char* kStopped = "it was interrupted";
constexpr std::string_view kName = "fire3dv-convert: ", kWarning = "warning: ";

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

// Line parser of the converter's output. The last line that is no warning is the error message.
class Said {
 public:
  void add(const char* bytes, size_t count) {
    for (size_t i = 0; i < count; ++i) {
      if (bytes[i] == '\n')
        end_line();
      else if (line_.size() < kMaxLineBytes)
        line_ += static_cast<uint8_t>(bytes[i]) < 0x20 ? ' ' : bytes[i];
    }
  }
  void end_line() {
    std::string_view text = line_;
    if (text.starts_with(kName)) text.remove_prefix(kName.size());
    if (text.starts_with(kWarning)) {
      text.remove_prefix(kWarning.size());
      if (warnings_.size() < kMaxWarnings) warnings_.emplace_back(text);
    } else if (!text.empty()) {
      last_ = text;
    }
    line_.clear();
  }
  std::vector<std::string> take_warnings() { return std::move(warnings_); }
  const std::string& last() const { return last_; }

 private:
  std::string line_, last_;
  std::vector<std::string> warnings_;
};

// Starts the process. Neither descriptor may be a standard one.
Result<pid_t> start(const std::string& program, const std::vector<std::string>& arguments,
                    int standard_output, int standard_error) {
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&files);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, standard_output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, standard_error, STDERR_FILENO);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t pid = 0;
  const int fault = posix_spawn(&pid, program.c_str(), &files, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (fault != 0) return Error{"cannot start " + program + ": " + std::strerror(fault)};
  return pid;
}

using Clock = std::chrono::steady_clock;

// Reason to end the converter, or nothing.
std::optional<std::string> why_end(const ConverterRun& wanted, Clock::time_point until) {
  if (wanted.should_stop && wanted.should_stop()) return kStopped;
  if (Clock::now() > until) return "it takes longer than " + std::to_string(kLongest.count()) + " minutes";
  return std::nullopt;
}

// Reads until the child closes its standard error. Returns the reason to end it, or nothing.
std::optional<std::string> listen_to(int from, const ConverterRun& wanted, Clock::time_point until,
                                     Said& said) {
  char bytes[4096];
  while (true) {
    pollfd ready{from, POLLIN, 0};
    if (::poll(&ready, 1, kPollMs) > 0) {
      const ssize_t got = ::read(from, bytes, sizeof bytes);
      if (got == 0 || (got < 0 && errno != EINTR && errno != EAGAIN)) return std::nullopt;
      if (got > 0) said.add(bytes, static_cast<size_t>(got));
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

}  // namespace

Result<std::string> converter_file() {
  std::error_code error;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return Error{"cannot find fire3dv-convert: the path of fire3dv itself is unknown"};
  const std::filesystem::path beside = own.parent_path() / "fire3dv-convert";
  if (::access(beside.c_str(), X_OK) != 0) {
    return Error{"descriptions are converted by fire3dv-convert, which is not beside fire3dv: " +
                 beside.string() + " (" + std::strerror(errno) + "); install it there"};
  }
  return beside.string();
}

Result<std::vector<std::string>> run_converter(const ConverterRun& wanted) {
  const Result<std::string> program = converter_file();
  if (!program) return program.error();
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
  const Result<pid_t> child = start(*program, wanted.arguments, output.get(), writing.get());
  writing.reset();
  output.reset();  // may also be the pipe's
  if (!child) return child.error();

  Said said;
  const Clock::time_point until = Clock::now() + kLongest;
  std::optional<std::string> ended = listen_to(reading.get(), wanted, until, said);
  // A terminal interrupt reaches both processes and may have ended the converter already.
  const int status = wait_for(*child, wanted, until, ended);
  said.end_line();
  if (ended) return Error{"the conversion was ended: " + *ended};
  if (WIFSIGNALED(status)) {
    return Error{"fire3dv-convert crashed (" + std::string(strsignal(WTERMSIG(status))) +
                 "): one of the files is more than a library can bear" +
                 (said.last().empty() ? "" : "; its last message: " + said.last())};
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return Error{said.last().empty() ? "fire3dv-convert failed without a reason" : said.last()};
  }
  return said.take_warnings();
}

}  // namespace fire3dv::app
