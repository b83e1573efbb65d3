// Threads that run tasks of clients. The next task is one of the client that has used the least time, so that
// nobody fills the queue for others; of this client, the cheapest one.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace fire3dv::drake {

struct WorkerOptions {
  unsigned threads = 1;
  uint64_t large_cost = UINT64_MAX;  // of several threads, one is left to tasks that cost less
  int nice = 0;                      // added to the threads' nice value
};

class WorkerPool {
 public:
  explicit WorkerPool(const WorkerOptions& options);
  ~WorkerPool();  // after stop(); waits for running tasks
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // task: must not throw. cost: any unit, the same for all tasks. From any thread.
  void push(const std::string& client, uint64_t cost, std::function<void()> task);
  // Drops the tasks that have not begun. False: some still run after this time.
  bool stop(std::chrono::milliseconds patience);

 private:
  using Clock = std::chrono::steady_clock;
  struct Task {
    std::string client;
    uint64_t cost;
    Clock::time_point since;
    std::function<void()> run;
  };
  void run();
  std::list<Task>::iterator choose();

  const WorkerOptions options_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::list<Task> tasks_;
  std::map<std::string, Clock::duration> used_;  // since tasks last ran out
  unsigned running_ = 0, running_large_ = 0, ended_ = 0;
  bool stopping_ = false;
  std::vector<std::thread> threads_;  // last: they use all others
};

}  // namespace fire3dv::drake
