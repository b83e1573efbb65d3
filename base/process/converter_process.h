// fire3dv-convert as a child process: description files are untrusted, and third-party libraries parse them.
// A crash there does not affect this process. For Linux.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv {

// Limit for callers that wait.
constexpr std::chrono::minutes kLongestConversion{15};

// Parser of the converter's standard error: warnings, and the last line that is none, which is the reason of
// a failure.
class ConverterMessages {
 public:
  void add(const char* bytes, size_t count);
  // Ends the last line.
  void finish() { end_line(); }

  std::vector<std::string> take_warnings() { return std::move(warnings_); }
  const std::string& last() const { return last_; }

 private:
  void end_line();

  std::string line_, last_;
  std::vector<std::string> warnings_;
};

// Path of the converter beside this program's executable. The error names the expected path.
Result<std::string> converter_file();

// Starts the converter with a closed standard input and limits of memory (16 GiB) and output
// (max_output_bytes a file). Uses neither PATH nor a shell. The caller waits for the process. Neither
// descriptor may be a standard one.
Result<pid_t> start_converter(const std::vector<std::string>& arguments, int standard_output,
                              int standard_error, uint64_t max_output_bytes);

// Error for an exit status of waitpid() other than success: a crash, or the converter's own reason.
Result<void> converter_result(int status, const ConverterMessages& messages);

}  // namespace fire3dv
