// Parallel loop over indices 0 to count - 1 on all cores, at most 16 threads. Jobs must be independent.
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace fire3dv::bench {

template <typename Job>
void for_each_index(size_t count, Job&& job) {
  std::atomic<size_t> next{0};
  const auto work = [&] {
    for (size_t i = next++; i < count; i = next++) job(i);
  };
  std::vector<std::jthread> helpers;
  const size_t threads = std::clamp<size_t>(std::thread::hardware_concurrency(), 1, 16);
  for (size_t i = 1; i < std::min(threads, count); ++i) helpers.emplace_back(work);
  work();
}

}  // namespace fire3dv::bench
