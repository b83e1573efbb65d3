#include "convert/xacro/xacro_program.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <vector>

#include "base/text.h"

namespace fire3dv::convert {
namespace {

constexpr std::chrono::seconds kMaxTime{120};
constexpr size_t kMaxBytes = size_t{64} << 20;

// Reads to the end of the pipe. Returns the reason to stop before it, or "".
std::string read_all(int from, std::string& text) {
  const auto until = std::chrono::steady_clock::now() + kMaxTime;
  char bytes[65536];
  while (true) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    if (left.count() <= 0) return "it takes longer than " + std::to_string(kMaxTime.count()) + " s";
    pollfd ready{from, POLLIN, 0};
    const int count = ::poll(&ready, 1, static_cast<int>(left.count()));
    if (count < 0 && errno != EINTR) return std::strerror(errno);
    if (count <= 0) continue;
    const ssize_t got = ::read(from, bytes, sizeof bytes);
    if (got == 0) return {};
    if (got < 0 && errno != EINTR) return std::strerror(errno);
    if (got > 0) text.append(bytes, static_cast<size_t>(got));
    if (text.size() > kMaxBytes) return "it writes more than " + std::to_string(kMaxBytes >> 20) + " MiB";
  }
}

}  // namespace

Result<std::string> run_xacro_program(const std::string& program, const std::filesystem::path& file,
                                      const std::map<std::string, std::string>& arguments) {
  // An absolute path is no option.
  std::vector<std::string> words{program, std::filesystem::absolute(file).string()};
  for (const auto& [name, value] : arguments) words.push_back(name + ":=" + value);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const std::string name = "the program " + quote(program);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return Error{"cannot run " + name + ": " + std::strerror(errno)};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  pid_t child = 0;
  const int fault = ::posix_spawnp(&child, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  if (fault != 0) {
    ::close(ends[0]);
    return Error{"cannot run " + name + ": " + std::strerror(fault)};
  }
  std::string text;
  const std::string stopped = read_all(ends[0], text);
  ::close(ends[0]);
  if (!stopped.empty()) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!stopped.empty()) return Error{name + " was ended: " + stopped};
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return Error{name + " failed on " + quote(file.string()) + "; its message is above"};
  return text;
}

}  // namespace fire3dv::convert
