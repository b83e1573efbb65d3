#include "renderer/doctor/child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <optional>
#include <string>
#include <thread>

#include "base/unique_fd.h"

namespace fire3dv::doctor {
namespace {

using Clock = std::chrono::steady_clock;
constexpr size_t kMaxAnswerBytes = 1 << 20;

[[noreturn]] void run_child(const std::function<nlohmann::json()>& experiment, int pipe_fd) {
  // Where standard files are closed, the pipe took one of their numbers.
  const int answer_fd =
      pipe_fd > STDERR_FILENO ? pipe_fd : ::fcntl(pipe_fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGCHLD}) ::signal(number, SIG_DFL);
  if (const int null = ::open("/dev/null", O_RDWR); null >= 0) {  // drivers print
    for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(null, fd);
  }
  nlohmann::json answer;
  try {
    answer["value"] = experiment();
  } catch (const std::exception& failure) {
    answer["error"] = failure.what();
  }
  const std::string text = answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  for (size_t done = 0; done < text.size();) {
    const ssize_t written = ::write(answer_fd, text.data() + done, text.size() - done);
    if (written <= 0 && errno != EINTR) break;
    done += static_cast<size_t>(std::max<ssize_t>(written, 0));
  }
  ::_exit(0);  // without the drivers' exit handlers
}

// Reads to the end of the pipe. Returns false at the deadline.
bool read_answer(int fd, Clock::time_point deadline, std::string& text) {
  std::array<char, 4096> bytes;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return false;
    pollfd wait{fd, POLLIN, 0};
    const int ready = ::poll(&wait, 1, static_cast<int>(std::min<int64_t>(left, 1000)));
    if (ready <= 0) continue;
    const ssize_t count = ::read(fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0 || text.size() > kMaxAnswerBytes) return true;
    text.append(bytes.data(), static_cast<size_t>(count));
  }
}

// A process that a driver keeps in the kernel cannot be waited for.
std::optional<int> wait_briefly(pid_t child, Clock::time_point deadline) {
  while (true) {
    int status = 0;
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child) return status;
    if (ended < 0 && errno != EINTR) return std::nullopt;
    if (Clock::now() > deadline) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

// Children of a process that ignores SIGCHLD, as a parent may have set it, cannot be waited for.
class WaitableChildren {
 public:
  WaitableChildren() {
    struct sigaction standard {};
    standard.sa_handler = SIG_DFL;
    ::sigaction(SIGCHLD, &standard, &before_);
  }
  ~WaitableChildren() { ::sigaction(SIGCHLD, &before_, nullptr); }
  WaitableChildren(const WaitableChildren&) = delete;
  WaitableChildren& operator=(const WaitableChildren&) = delete;

 private:
  struct sigaction before_ {};
};

std::string signal_name(int number) {
  const char* const name = ::sigabbrev_np(number);
  return name ? std::string("SIG") + name : "signal " + std::to_string(number);
}

}  // namespace

ChildResult run_in_child(const std::function<nlohmann::json()>& experiment, std::chrono::milliseconds limit) {
  ChildResult result;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    result.trial = {Outcome::failed, std::string("no pipe can be opened: ") + std::strerror(errno)};
    return result;
  }
  UniqueFd reader(ends[0]), writer(ends[1]);
  const WaitableChildren waitable;
  const pid_t child = ::fork();
  if (child < 0) {
    result.trial = {Outcome::failed, std::string("no process can be started: ") + std::strerror(errno)};
    return result;
  }
  if (child == 0) run_child(experiment, writer.get());
  writer = UniqueFd();
  std::string text;
  const Clock::time_point deadline = Clock::now() + limit;
  constexpr std::chrono::seconds kEnd{2};
  const bool answered = read_answer(reader.get(), deadline, text);
  std::optional<int> status;
  if (answered) status = wait_briefly(child, std::max(deadline, Clock::now() + kEnd));
  if (!status) {
    ::kill(-child, SIGKILL);
    ::kill(child, SIGKILL);
    wait_briefly(child, Clock::now() + kEnd);
    const double limit_s = static_cast<double>(limit.count()) / 1000;
    char text_of_limit[32];
    std::snprintf(text_of_limit, sizeof text_of_limit, "%.6g s", limit_s);
    result.trial = {Outcome::hung, text_of_limit};
    return result;
  }
  if (WIFSIGNALED(*status)) {
    result.trial = {Outcome::crashed, signal_name(WTERMSIG(*status))};
    return result;
  }
  const nlohmann::json answer = nlohmann::json::parse(text, nullptr, false);
  if (!answer.is_object()) {
    result.trial = {Outcome::crashed, "exit status " + std::to_string(WEXITSTATUS(*status))};
  } else if (answer.contains("error")) {
    result.trial = {Outcome::failed, answer["error"].get<std::string>()};
  } else {
    result.trial.outcome = Outcome::passed;
    result.value = answer.value("value", nlohmann::json());
  }
  return result;
}

}  // namespace fire3dv::doctor
