// Deadline of a stop request. A program that still waits for a device, a driver or a loading thread then
// completes its files and ends without that wait: the kernel frees what is left.
#pragma once

#include <functional>
#include <optional>

namespace fire3dv {

// Starts the watching thread, once a process, before install_stop_signals(). program: name in the log line.
// exit_code: of a program that ends at the deadline, unless an exit task returns a larger one.
void start_stop_deadline(const char* program, int exit_code);

// Completion of a file, once: by its owner, or at the deadline by the watching thread, while the owner's
// thread may still wait or go on. Later tasks run first then. Once the deadline has passed, owners block
// here: the program is about to end.
class ExitTask {
 public:
  // finish: returns an exit code.
  explicit ExitTask(std::function<int()> finish);
  ~ExitTask();
  ExitTask(const ExitTask&) = delete;
  ExitTask& operator=(const ExitTask&) = delete;

  int run();  // returns the exit code of the first run

 private:
  friend struct StopDeadline;
  int run_once();  // requires the mutex

  const std::function<int()> finish_;
  std::optional<int> exit_code_;
};

}  // namespace fire3dv
