// Log lines of one kind, a few at most: a fault of each of thousands of frames is reported for the first
// five.
#pragma once

#include <map>
#include <string>

#include "base/log.h"

namespace fire3dv::ros2 {

inline void log_line(const std::string& text) {
  print_log_line("fire3dv-ros2", text);
}

class LimitedLog {
 public:
  void warn(const std::string& kind, const std::string& text) {
    size_t& count = counts_[kind];
    if (++count <= kMaxLines)
      log_line(warning(text));
    else if (count == kMaxLines + 1)
      log_line(warning("further warnings about " + kind + " are not shown"));
  }

 private:
  static constexpr size_t kMaxLines = 5;

  std::map<std::string, size_t> counts_;
};

}  // namespace fire3dv::ros2
