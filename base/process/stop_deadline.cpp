#include "base/process/stop_deadline.h"

#include <semaphore.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <ranges>
#include <thread>
#include <utility>
#include <vector>

#include "base/log.h"
#include "base/process/stop_signals.h"

namespace fire3dv {

// Never destroyed: the watching thread outlives main().
struct StopDeadline {
  static StopDeadline& get() {
    static auto* const deadline = new StopDeadline;
    return *deadline;
  }

  StopDeadline() { ::sem_init(&begun, 0, 0); }

  [[noreturn]] void watch(const char* program, int exit_code) {
    // A user expects the end within 2 s; the rest of them is for the files.
    constexpr std::chrono::milliseconds kPatience{1200};
    while (::sem_wait(&begun) != 0) {
    }
    std::this_thread::sleep_for(kPatience);
    const std::lock_guard lock(mutex);  // until the end: no other thread ends a task's owner
    for (ExitTask* const task : std::views::reverse(tasks)) exit_code = std::max(exit_code, task->run_once());
    print_log_line(program,
                   "info: stopped without waiting for what is being drawn or loaded; files are complete");
    // Destructors would wait for the device, whose work may take minutes.
    std::_Exit(exit_code);
  }

  sem_t begun;  // a handler may post it
  std::mutex mutex;
  std::vector<ExitTask*> tasks;
};

void start_stop_deadline(const char* program, int exit_code) {
  StopDeadline& deadline = StopDeadline::get();
  std::thread([&deadline, program, exit_code] { deadline.watch(program, exit_code); }).detach();
  after_stop_request = [] {  // on any thread, at any point: it takes no lock
    const int before = errno;
    ::sem_post(&StopDeadline::get().begun);
    errno = before;
  };
}

ExitTask::ExitTask(std::function<int()> finish) : finish_(std::move(finish)) {
  StopDeadline& deadline = StopDeadline::get();
  const std::lock_guard lock(deadline.mutex);
  deadline.tasks.push_back(this);
}

int ExitTask::run_once() {
  if (!exit_code_) exit_code_ = finish_();
  return *exit_code_;
}

int ExitTask::run() {
  const std::lock_guard lock(StopDeadline::get().mutex);
  return run_once();
}

ExitTask::~ExitTask() {
  StopDeadline& deadline = StopDeadline::get();
  const std::lock_guard lock(deadline.mutex);
  std::erase(deadline.tasks, this);
}

}  // namespace fire3dv
