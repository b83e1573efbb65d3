#include "programs/drake/render/worker_pool.h"

#include <sys/resource.h>
#include <unistd.h>

#include <utility>

namespace fire3dv::drake {
namespace {

// A task that has waited for so long is no longer overtaken by cheaper ones of its client.
constexpr std::chrono::seconds kLongWait{2};

}  // namespace

WorkerPool::WorkerPool(const WorkerOptions& options) : options_(options) {
  for (unsigned i = 0; i < options.threads; ++i) threads_.emplace_back([this] { run(); });
}

WorkerPool::~WorkerPool() {
  (void)stop(std::chrono::milliseconds(0));
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::push(const std::string& client, uint64_t cost, std::function<void()> task) {
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    tasks_.push_back({client, cost, Clock::now(), std::move(task)});
    used_.try_emplace(client);
  }
  changed_.notify_all();
}

bool WorkerPool::stop(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  stopping_ = true;
  changed_.notify_all();
  return changed_.wait_for(lock, patience, [this] { return ended_ == threads_.size(); });
}

std::list<WorkerPool::Task>::iterator WorkerPool::choose() {
  const auto now = Clock::now();
  const auto cost_of = [&](const Task& task) { return now - task.since > kLongWait ? 0 : task.cost; };
  auto best = tasks_.end();
  for (auto task = tasks_.begin(); task != tasks_.end(); ++task) {
    if (task->cost >= options_.large_cost && options_.threads > 1 && running_large_ + 1 >= options_.threads)
      continue;
    if (best != tasks_.end() &&
        std::pair(used_[task->client], cost_of(*task)) >= std::pair(used_[best->client], cost_of(*best)))
      continue;
    best = task;
  }
  return best;
}

void WorkerPool::run() {
  // On Linux a thread has a nice value of its own.
  if (options_.nice != 0)
    (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()),
                        ::getpriority(PRIO_PROCESS, 0) + options_.nice);
  std::unique_lock lock(mutex_);
  for (;;) {
    auto next = tasks_.end();
    changed_.wait(lock, [&] {
      if (!stopping_) next = choose();
      return stopping_ || next != tasks_.end();
    });
    if (stopping_) break;
    Task task = std::move(*next);
    tasks_.erase(next);
    const bool is_large = task.cost >= options_.large_cost;
    ++running_;
    running_large_ += is_large ? 1 : 0;
    lock.unlock();
    const Clock::time_point begin = Clock::now();
    task.run();
    task.run = nullptr;
    lock.lock();
    --running_;
    running_large_ -= is_large ? 1 : 0;
    used_[task.client] += Clock::now() - begin;
    if (tasks_.empty() && running_ == 0) used_.clear();
    if (is_large) changed_.notify_all();
  }
  ++ended_;
  changed_.notify_all();
}

}  // namespace fire3dv::drake
