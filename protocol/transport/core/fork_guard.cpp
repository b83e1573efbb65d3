#include "protocol/transport/core/fork_guard.h"

#include <fcntl.h>
#include <pthread.h>

#include <atomic>
#include <mutex>
#include <set>

namespace fire3dv::transport {
namespace {

std::atomic<unsigned> generation{0};

// Never destroyed: links may outlive static objects, and fork() may be called at any time.
struct Registry {
  std::mutex mutex;
  std::set<int> fds;
};
Registry& registry() {
  static Registry* const the_one = [] {
    auto* made = new Registry;
    // The lock is held across fork(), so that the child sees a consistent set.
    ::pthread_atfork([] { registry().mutex.lock(); }, [] { registry().mutex.unlock(); },
                     [] {
                       // Replaces the descriptor by one of /dev/null. A closed number could be reused while
                       // its owner object in the child still holds it.
                       const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
                       for (const int fd : registry().fds)
                         if (nothing < 0 || ::dup3(nothing, fd, O_CLOEXEC) < 0) ::close(fd);
                       if (nothing >= 0) ::close(nothing);
                       registry().fds.clear();
                       generation.fetch_add(1, std::memory_order_relaxed);
                       registry().mutex.unlock();
                     });
    return made;
  }();
  return *the_one;
}

void unregister(int fd) {
  const std::lock_guard lock(registry().mutex);
  registry().fds.erase(fd);
}

}  // namespace

// The pre-fork handler waits for this lock. A child forked between open and registration would keep the
// descriptor and its parent's lock.
UnforkableFd UnforkableFd::open(const std::function<int()>& open) {
  UnforkableFd opened;
  const std::lock_guard lock(registry().mutex);
  opened.fd_ = UniqueFd(open());
  if (opened.fd_) registry().fds.insert(opened.fd_.get());
  return opened;
}

UnforkableFd::UnforkableFd(UnforkableFd&& other) noexcept = default;
UnforkableFd& UnforkableFd::operator=(UnforkableFd&& other) noexcept = default;

// Unregisters before closing: afterwards the number may be reused.
UnforkableFd::~UnforkableFd() {
  if (fd_) unregister(fd_.get());
}

unsigned fork_generation() {
  registry();  // the first call installs the fork handlers
  return generation.load(std::memory_order_relaxed);
}

}  // namespace fire3dv::transport
