// Tests of the threads that run tasks of clients.
#include "programs/drake/render/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace fire3dv::drake {
namespace {

// Tasks that wait until they are opened, and a log of those that have run.
class Gate {
 public:
  void wait() {
    std::unique_lock lock(mutex_);
    ++waiting_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return is_open_; });
  }
  void await(int waiting) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waiting_ >= waiting; });
  }
  void open() {
    const std::lock_guard lock(mutex_);
    is_open_ = true;
    changed_.notify_all();
  }
  void log(char name) {
    const std::lock_guard lock(mutex_);
    log_ += name;
    changed_.notify_all();
  }
  std::string await_log(size_t size) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return log_.size() >= size; });
    return log_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int waiting_ = 0;
  bool is_open_ = false;
  std::string log_;
};

TEST(DrakeWorkers, OtherClientsComeFirst) {
  Gate gate;
  WorkerPool pool({});
  pool.push("flood", 1, [&] { gate.wait(); });
  gate.await(1);
  for (const char name : {'a', 'b', 'c'}) pool.push("flood", 1, [&gate, name] { gate.log(name); });
  pool.push("honest", 100, [&] { gate.log('h'); });
  gate.open();
  EXPECT_EQ(gate.await_log(4), "habc");
}

TEST(DrakeWorkers, CheapTasksOfOneClientComeFirst) {
  Gate gate;
  WorkerPool pool({});
  pool.push("one", 1, [&] { gate.wait(); });
  gate.await(1);
  pool.push("one", 9, [&] { gate.log('9'); });
  pool.push("one", 2, [&] { gate.log('2'); });
  pool.push("one", 5, [&] { gate.log('5'); });
  gate.open();
  EXPECT_EQ(gate.await_log(3), "259");
}

TEST(DrakeWorkers, LargeTasksLeaveAThread) {
  Gate gate;
  WorkerPool pool({.threads = 2, .large_cost = 10});
  pool.push("one", 20, [&] { gate.wait(); });
  gate.await(1);
  pool.push("one", 20, [&] { gate.log('L'); });
  for (const char name : {'a', 'b'}) pool.push("one", 1, [&gate, name] { gate.log(name); });
  EXPECT_EQ(gate.await_log(2), "ab");
  gate.open();
  EXPECT_EQ(gate.await_log(3), "abL");
}

TEST(DrakeWorkers, StopDropsTasks) {
  Gate gate;
  std::atomic<bool> has_run = false;
  WorkerPool pool({});
  pool.push("one", 1, [&] { gate.wait(); });
  gate.await(1);
  pool.push("one", 1, [&] { has_run = true; });
  EXPECT_FALSE(pool.stop(std::chrono::milliseconds(1)));
  gate.open();
  EXPECT_TRUE(pool.stop(std::chrono::minutes(1)));
  EXPECT_FALSE(has_run);
}

}  // namespace
}  // namespace fire3dv::drake
