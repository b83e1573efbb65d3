// Facts of this machine for `fire3dv doctor`. Experiments run in child processes: nothing here crashes or
// waits longer than its limit.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "renderer/doctor/facts.h"

namespace fire3dv::doctor {

// Addresses whose ports are tried.
struct Addresses {
  std::vector<std::string> listen;  // URIs
  std::string serve, metrics;       // HOST:PORT; empty: none
};

// limit: of each experiment.
Facts gather_facts(const Addresses& addresses, std::chrono::milliseconds limit);

}  // namespace fire3dv::doctor
