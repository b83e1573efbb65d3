// Checks of `fire3dv doctor`: a table of functions from facts to findings, without access to the system.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "renderer/doctor/facts.h"

namespace fire3dv::doctor {

enum class Level { ok, note, warning, error };
const char* level_name(Level level);

struct Finding {
  Level level = Level::ok;
  std::string text;  // one sentence that names the fault
  std::string fix;   // the line to type; empty: none
};

struct Check {
  const char* id;  // stable: scripts match it
  // Empty: the check does not apply to this machine.
  std::vector<Finding> (*run)(const Facts& facts);
};

// In the order of the report: drivers, devices, system.
std::vector<Check> all_checks();
std::span<const Check> driver_checks();
std::span<const Check> device_checks();
std::span<const Check> system_checks();

struct CheckedFinding {
  std::string id;
  Finding finding;
};
std::vector<CheckedFinding> run_checks(const Facts& facts);

// Exit status of the program: 1 if anything is broken, which is an error.
int exit_status(std::span<const CheckedFinding> findings);

// The fault of an experiment that went wrong: "hangs (for more than 20 s)", "crashes (SIGSEGV)", or "fails:
// ...".
std::string describe(const Trial& trial);

}  // namespace fire3dv::doctor
