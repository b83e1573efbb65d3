#include "base/process/converter_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

extern char** environ;

namespace fire3dv {
namespace {

constexpr rlim_t kMaxMemoryBytes = rlim_t{16} << 30;
constexpr size_t kMaxLineBytes = 4096, kMaxWarnings = 1000;

void lower_limit(pid_t child, __rlimit_resource resource, rlim_t most) {
  rlimit limit{};
  if (::prlimit(child, resource, nullptr, &limit) != 0) return;
  limit.rlim_max = std::min(limit.rlim_max, most);
  limit.rlim_cur = std::min(limit.rlim_cur, limit.rlim_max);
  ::prlimit(child, resource, &limit, nullptr);
}

// A short file may ask for any amount of memory and output. Processes of the converter inherit the limits.
void limit_resources(pid_t child, uint64_t max_output_bytes) {
  lower_limit(child, RLIMIT_CORE, 0);
  lower_limit(child, RLIMIT_FSIZE, max_output_bytes);
#if !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)  // they reserve terabytes of address space
  lower_limit(child, RLIMIT_AS, kMaxMemoryBytes);
#endif
}

}  // namespace

void ConverterMessages::add(const char* bytes, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    if (bytes[i] == '\n')
      end_line();
    else if (line_.size() < kMaxLineBytes)
      line_ += static_cast<uint8_t>(bytes[i]) < 0x20 ? ' ' : bytes[i];
  }
}

void ConverterMessages::end_line() {
  constexpr std::string_view kName = "fire3dv-convert: ", kWarning = "warning: ";
  std::string_view text = line_;
  if (text.starts_with(kName)) text.remove_prefix(kName.size());
  for (const std::string_view level : {std::string_view("error: "), std::string_view("info: ")})
    if (text.starts_with(level)) text.remove_prefix(level.size());
  if (text.starts_with(kWarning)) {
    text.remove_prefix(kWarning.size());
    if (warnings_.size() < kMaxWarnings) warnings_.emplace_back(text);
  } else if (!text.empty()) {
    last_ = text;
  }
  line_.clear();
}

Result<std::string> converter_file() {
  std::error_code error;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return Error{"cannot find fire3dv-convert: the path of this program is unknown"};
  const std::filesystem::path beside = own.parent_path() / "fire3dv-convert";
  if (::access(beside.c_str(), X_OK) != 0) {
    return Error{"this file is converted by fire3dv-convert, which is not beside " + own.filename().string() +
                 ": " + beside.string() + " (" + std::strerror(errno) + "); install it there"};
  }
  return beside.string();
}

Result<pid_t> start_converter(const std::vector<std::string>& arguments, int standard_output,
                              int standard_error, uint64_t max_output_bytes) {
  const Result<std::string> program = converter_file();
  if (!program) return program.error();
  std::vector<std::string> words{*program};
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
  const int fault = posix_spawn(&pid, program->c_str(), &files, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (fault != 0) return Error{"cannot start " + *program + ": " + std::strerror(fault)};
  limit_resources(pid, max_output_bytes);
  return pid;
}

Result<void> converter_result(int status, const ConverterMessages& messages) {
  if (WIFSIGNALED(status)) {
    return Error{"fire3dv-convert crashed (" + std::string(strsignal(WTERMSIG(status))) +
                 "): one of the files is more than a library can bear" +
                 (messages.last().empty() ? "" : "; its last message: " + messages.last())};
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return Error{messages.last().empty() ? "fire3dv-convert failed without a reason" : messages.last()};
  return {};
}

}  // namespace fire3dv
