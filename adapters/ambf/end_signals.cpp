#include "adapters/ambf/end_signals.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <system_error>
#include <utility>

#include "adapters/ambf/log.h"

namespace fire3dv::ambf {
namespace {

std::atomic<int> wake_fd{-1};
std::atomic<pid_t> owner{0};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<pid_t>::is_always_lock_free);

// Signal handler; async-signal-safe. A child between fork and exec inherits it but must not close its
// parent's streams.
void on_signal(int number) {
  const int saved = errno;
  if (owner.load() != ::getpid()) {
    ::signal(number, SIG_DFL);
    ::raise(number);
  } else if (const int fd = wake_fd.load(); fd >= 0) {
    const auto byte = static_cast<unsigned char>(number);
    [[maybe_unused]] const ssize_t written = ::write(fd, &byte, 1);  // pipe full: the thread is awake already
  }
  errno = saved;
}

}  // namespace

EndSignals::EndSignals(std::function<void()> close) : close_(std::move(close)) {
  int fds[2];
  if (::pipe2(fds, O_CLOEXEC) != 0) {
    log_line("no pipe can be made, so a stream will be left open when AMBF is ended by SIGTERM");
    return;
  }
  read_fd_ = fds[0];
  ::fcntl(fds[1], F_SETFL, O_NONBLOCK);
  wake_fd = fds[1];
  owner = ::getpid();

  // The thread blocks all signals, since AMBF's handlers must run on AMBF's threads.
  sigset_t all, saved;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &saved);
  try {
    thread_ = std::thread([this] { wait_for_signal(); });
  } catch (const std::system_error&) {
    // Thread limit of the process reached.
  }
  pthread_sigmask(SIG_SETMASK, &saved, nullptr);
  if (!thread_.joinable()) {
    wake_fd = -1;
    ::close(fds[0]);
    ::close(fds[1]);
    log_line("no thread can be started, so a stream will be left open when AMBF is ended by SIGTERM");
    return;
  }

  for (size_t i = 0; i < kSignals.size(); ++i) {
    struct sigaction action {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    if (::sigaction(kSignals[i], nullptr, &before_[i]) != 0) continue;
    if (before_[i].sa_handler == SIG_IGN) continue;  // the parent process made AMBF ignore this signal
    ours_[i] = ::sigaction(kSignals[i], &action, nullptr) == 0;
  }
}

EndSignals::~EndSignals() {
  if (!thread_.joinable()) return;
  put_back();
  const int fd = wake_fd.exchange(-1);
  const unsigned char end = 0;
  // The pipe may be full of signals; the thread ends at the first byte.
  [[maybe_unused]] const ssize_t written = ::write(fd, &end, 1);
  thread_.join();
  ::close(fd);
  ::close(read_fd_);
}

void EndSignals::wait_for_signal() {
  unsigned char number = 0;
  while (::read(read_fd_, &number, 1) < 0 && errno == EINTR) {
  }
  if (number == 0) return;
  close_();
  put_back();
  ::kill(::getpid(), number);  // all signals are blocked on this thread, so that another thread receives it
}

void EndSignals::put_back() {
  const std::lock_guard<std::mutex> lock(put_back_);
  for (size_t i = 0; i < kSignals.size(); ++i) {
    struct sigaction now {};
    if (!ours_[i] || ::sigaction(kSignals[i], nullptr, &now) != 0 || now.sa_handler != on_signal) continue;
    ::sigaction(kSignals[i], &before_[i], nullptr);
    ours_[i] = false;
  }
}

}  // namespace fire3dv::ambf
