#include "renderer/doctor/check.h"

#include <algorithm>

namespace fire3dv::doctor {

const char* level_name(Level level) {
  switch (level) {
    case Level::ok:
      return "ok";
    case Level::note:
      return "note";
    case Level::warning:
      return "warning";
    case Level::error:
      return "error";
  }
  return "error";
}

std::vector<Check> all_checks() {
  std::vector<Check> checks;
  for (const std::span<const Check> group : {driver_checks(), device_checks(), system_checks()})
    checks.insert(checks.end(), group.begin(), group.end());
  return checks;
}

std::vector<CheckedFinding> run_checks(const Facts& facts) {
  std::vector<CheckedFinding> findings;
  // Without experiments nothing is known of drivers and devices.
  const std::span<const Check> system = system_checks();
  const std::vector<Check> checks =
      facts.experiments_fault.empty() ? all_checks() : std::vector<Check>(system.begin(), system.end());
  for (const Check& check : checks) {
    for (Finding& finding : check.run(facts)) findings.push_back({check.id, std::move(finding)});
  }
  return findings;
}

int exit_status(std::span<const CheckedFinding> findings) {
  return std::any_of(findings.begin(), findings.end(),
                     [](const CheckedFinding& f) { return f.finding.level == Level::error; })
             ? 1
             : 0;
}

std::string describe(const Trial& trial) {
  switch (trial.outcome) {
    case Outcome::hung:
      return trial.detail.empty() ? "hangs" : "hangs (for more than " + trial.detail + ")";
    case Outcome::crashed:
      return "crashes (" + trial.detail + ")";
    case Outcome::failed:
      return "fails: " + trial.detail;
    case Outcome::not_tried:
      return "was not tried";
    case Outcome::passed:
      return "works";
  }
  return "fails";
}

}  // namespace fire3dv::doctor
