// Experiment in a child process with a time limit: drivers may crash or hang, and take only the child along.
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>

#include "renderer/doctor/facts.h"

namespace fire3dv::doctor {

struct ChildResult {
  Trial trial;
  nlohmann::json value;  // what the experiment returned; null unless it passed
};

// Runs `experiment` in a forked child without standard input and output, and returns its value. An exception
// is a failure with that text. A child that exceeds the limit is killed with its own children. The calling
// process must have one thread, and must not have called Vulkan.
ChildResult run_in_child(const std::function<nlohmann::json()>& experiment, std::chrono::milliseconds limit);

}  // namespace fire3dv::doctor
