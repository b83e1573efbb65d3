// fire3dv-convert as a child process: description files are untrusted, and third-party libraries parse them.
// A crash there does not affect this process.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "protocol/base/error.h"

namespace fire3dv::app {

struct ConverterRun {
  std::vector<std::string> arguments;  // without the program's name
  int standard_output = -1;            // file descriptor for its standard output; -1: none
  // Polled ten times a second; true ends the converter.
  std::function<bool()> should_stop;
};

// Path of the converter next to this program's executable. The error names the expected path.
Result<std::string> converter_file();

// Runs the converter to its end. Returns its warnings, or its error message. Uses neither PATH nor a shell.
Result<std::vector<std::string>> run_converter(const ConverterRun& wanted);

}  // namespace fire3dv::app
