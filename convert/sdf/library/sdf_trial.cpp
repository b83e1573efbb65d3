#include "convert/sdf/library/sdf_trial.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <new>

namespace fire3dv::convert {
namespace {

constexpr rlim_t kMaxSeconds = 300;
#if !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)  // they reserve terabytes of address space
constexpr rlim_t kMaxMemoryBytes = rlim_t{12} << 30;
#endif
constexpr int kNoMemory = 3;

void lower_limit(__rlimit_resource resource, rlim_t most) {
  rlimit limit{};
  if (::getrlimit(resource, &limit) != 0) return;
  limit.rlim_cur = std::min(limit.rlim_cur, most);
  ::setrlimit(resource, &limit);
}

[[noreturn]] void run(const std::function<void()>& function) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int each : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGXCPU, SIGALRM})
    ::signal(each, SIG_DFL);
  ::alarm(2 * kMaxSeconds);  // a process that waits takes no processor time
  lower_limit(RLIMIT_CORE, 0);
  lower_limit(RLIMIT_CPU, kMaxSeconds);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  lower_limit(RLIMIT_AS, kMaxMemoryBytes);
#endif
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
  try {
    function();
  } catch (const std::bad_alloc&) {
    ::_exit(kNoMemory);
  } catch (...) {  // the caller meets it again
  }
  ::_exit(0);
}

}  // namespace

Result<void> try_in_process(const std::function<void()>& function) {
  const pid_t child = ::fork();
  if (child < 0) return Error{std::string("cannot start a process: ") + std::strerror(errno)};
  if (child == 0) run(function);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return Error{std::string("a process was lost: ") + std::strerror(errno)};
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGALRM))
    return Error{"it takes longer than " + std::to_string(kMaxSeconds) + " seconds"};
  if (WIFSIGNALED(status)) return Error{std::string("it crashed (") + ::strsignal(WTERMSIG(status)) + ")"};
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNoMemory)
    return Error{"it needs more than 12 GiB of memory"};
  return {};
}

}  // namespace fire3dv::convert
