// fire3dv-convert, run as a program of its own: descriptions and the files that they name come from anywhere,
// and libraries of others read them. What goes wrong there ends that program and not this one.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::app {

struct ConverterRun {
  std::vector<std::string> arguments;  // without the program's name
  int standard_output = -1;            // a file descriptor that its standard output becomes; -1: none
  // Asked ten times a second; true ends the converter.
  std::function<bool()> should_stop;
};

// The program: the one beside this program's own file. The error names the place where it is not.
Result<std::string> converter_file();

// Waits until it has ended. Its warnings, or an error that holds its own sentence. No search path is followed
// and no shell started.
Result<std::vector<std::string>> run_converter(const ConverterRun& wanted);

}  // namespace fire3dv::app
