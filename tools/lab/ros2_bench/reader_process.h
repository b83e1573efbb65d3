// Reader of the benchmark's images, in a process of its own: this program again.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "adapters/ros2/dds/participant.h"
#include "base/error.h"

namespace fire3dv::ros2 {

[[noreturn]] void fail(const std::string& what);

template <typename Value>
Value take(Result<Value> result) {
  if (!result) fail(result.error().message);
  return std::move(*result);
}

// Monotonic clock of the machine; images carry it as their stamp.
int64_t now_ns();
std::unique_ptr<Participant> open_participant();
double quantile(std::vector<double>& values, double share);

class ReaderProcess {
 public:
  ReaderProcess(const std::string& topic, bool compressed);

  void wait_matched();
  struct Figures {
    size_t count = 0;
    double median_ms = 0, p99_ms = 0;  // from the stamp to the reader
  };
  Figures finish();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string line();

  pid_t process_ = 0;
  int input_ = -1;
  std::unique_ptr<std::FILE, CloseFile> output_;
};

// The process itself: reads messages until its standard input ends, then prints "COUNT MEDIAN_MS P99_MS".
// Returns the exit code.
int read_messages(const std::string& topic, bool compressed);

}  // namespace fire3dv::ros2
