#include "base/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace fire3dv {

void parallel_for(size_t count, const std::function<void(size_t)>& work,
                  const std::function<void(size_t done)>& progress) {
  std::atomic<size_t> next{0}, done{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto take_turns = [&](bool report) {
    try {
      for (size_t i = next++; i < count; i = next++) {
        work(i);
        const size_t finished = ++done;
        if (report && progress) progress(finished);
      }
    } catch (...) {
      next = count;  // stops further iterations
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    const size_t threads = std::min<size_t>(std::max(std::thread::hardware_concurrency(), 1u), count);
    std::vector<std::jthread> helpers;
    try {
      for (size_t i = 1; i < threads; ++i) helpers.emplace_back(take_turns, false);
    } catch (const std::system_error&) {
      // Thread creation failed: the existing threads do the work.
    }
    take_turns(true);
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace fire3dv
