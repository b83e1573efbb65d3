// Expansion by the program xacro of a ROS installation, which evaluates arbitrary Python. It runs only if the
// user names it.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "base/error.h"

namespace fire3dv::convert {

// Runs PROGRAM FILE NAME:=VALUE..., without a shell. Returns its standard output. The error has the reason;
// the program's messages go to standard error.
Result<std::string> run_xacro_program(const std::string& program, const std::filesystem::path& file,
                                      const std::map<std::string, std::string>& arguments);

}  // namespace fire3dv::convert
