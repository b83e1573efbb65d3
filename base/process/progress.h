// Progress display of long jobs of all programs.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace fire3dv {

// One rewritten line of stderr on a terminal, an occasional line elsewhere. Jobs of less than a second print
// nothing. For one thread.
class Progress {
 public:
  // what: begins each line, with the program's name before it.
  Progress(std::string program, std::string what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(uint64_t done, uint64_t total);  // total 0 = unknown
  // Adds the remaining time, extrapolated from the rate since the first call.
  void update_with_end(uint64_t done, uint64_t total);
  // Job with several stages: shows a bar and a percentage of the stage.
  void update(const char* stage, uint64_t done, uint64_t total);

 private:
  bool is_due();
  void show(const std::string& text);

  std::string program_, what_;
  bool terminal_;
  bool line_open_ = false;
  std::chrono::steady_clock::time_point begun_, last_;
  std::optional<uint64_t> done_at_first_;
};

}  // namespace fire3dv
