// How far a long job is: one line that is rewritten on a terminal, a line now and then elsewhere. Short jobs
// say nothing.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace fire3dv::app {

class Progress {
 public:
  explicit Progress(std::string what);
  ~Progress();
  void update(uint64_t done, uint64_t total);  // total 0 = unknown
  // The same with the time that is left, if the rest goes as fast as what was done since the first call.
  void update_with_end(uint64_t done, uint64_t total);
  // A job of several stages: a bar and a percentage of the stage.
  void update(const char* stage, uint64_t done, uint64_t total);

 private:
  bool is_due();
  void show(const std::string& text);

  std::string what_;
  bool terminal_;
  bool line_open_ = false;
  std::chrono::steady_clock::time_point begun_, last_;
  std::optional<uint64_t> done_at_first_;
};

}  // namespace fire3dv::app
