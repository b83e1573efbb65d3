#include "protocol/transport/core/link_thread.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "base/clock.h"
#include "base/process/start_thread.h"

namespace fire3dv::transport {

Result<void> LinkThread::start(const std::string& name, std::function<void()> body) {
  if (!waker_) return Error{name + ": out of file descriptors; close some or raise the limit"};
  owner_ = ::getpid();
  try {
    thread_ = std::thread(std::move(body));
  } catch (const std::system_error& failure) {
    return Error{name + ": " + thread_failure_text("link's", failure.code())};
  }
  return {};
}

void LinkThread::stop() {
  stop_.store(true, std::memory_order_relaxed);
  waker_.wake();
  if (!thread_.joinable()) return;
  if (owner_ == ::getpid())
    thread_.join();
  else
    thread_.detach();  // a forked child has no such thread, and join() would block forever
}

void LinkThread::pause(int64_t ns) {
  const int64_t until = monotonic_ns() + ns;
  for (int64_t now = monotonic_ns(); now < until && !stopping(); now = monotonic_ns())
    wait(-1, 0, until - now);
}

short LinkThread::wait(int fd, short events, int64_t timeout_ns) {
  const int64_t whole_ms = (std::max<int64_t>(timeout_ns, 0) + kMillisecondNs - 1) / kMillisecondNs;
  return waker_.wait(fd, events, static_cast<int>(whole_ms));
}

bool LinkThread::wait_for(int fd, short events, int64_t until_ns) {
  while (!stopping()) {
    const int64_t now = monotonic_ns();
    if (now >= until_ns) return false;
    if (wait(fd, events, until_ns - now) != 0) return true;
  }
  return false;
}

}  // namespace fire3dv::transport
