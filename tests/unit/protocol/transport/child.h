// Child processes of tests: one that is killed in every case, and one that runs step by step under ptrace.
#pragma once

#include <signal.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>

namespace fire3dv::transport::test {

// Runs `body` until killed.
class Child {
 public:
  explicit Child(const std::function<void()>& body) : pid_(::fork()) {
    if (pid_ != 0) return;
    body();
    ::_exit(0);
  }
  ~Child() { kill(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void signal(int number) { ::kill(pid_, number); }
  // Waits for its own end.
  void join() {
    if (pid_ > 0) ::waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }
  void kill() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }

 protected:
  pid_t pid_;
};

// Runs only on request. `body` delimits its steps of interest with mark().
class SteppedChild : public Child {
 public:
  enum class Stop { step, mark, ended };

  explicit SteppedChild(const std::function<void()>& body)
      : Child([&] {
          ::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
          body();
        }) {
    wait();
    if (stopped()) ::ptrace(PTRACE_SETOPTIONS, pid_, nullptr, PTRACE_O_TRACESYSGOOD | PTRACE_O_EXITKILL);
  }

  static void mark() { ::raise(SIGSTOP); }

  bool stopped() const { return pid_ > 0 && WIFSTOPPED(status_); }
  bool ended_well() const { return WIFEXITED(status_) && WEXITSTATUS(status_) == 0; }

  Stop instruction() { return go(PTRACE_SINGLESTEP); }
  // Runs to the entry or the exit of the next system call.
  Stop system_call() { return go(PTRACE_SYSCALL); }
  Stop to_mark() { return go(PTRACE_CONT); }

 private:
  Stop go(__ptrace_request request) {
    if (!stopped()) return Stop::ended;
    ::ptrace(request, pid_, nullptr, nullptr);
    wait();
    if (!stopped()) return Stop::ended;
    return WSTOPSIG(status_) == SIGSTOP ? Stop::mark : Stop::step;
  }
  void wait() {
    ::waitpid(pid_, &status_, 0);
    if (!stopped()) pid_ = 0;
  }

  int status_ = 0;
};

}  // namespace fire3dv::transport::test
