// Report of `fire3dv doctor` as text, as JSON, and as a file for an issue.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "renderer/doctor/check.h"

namespace fire3dv::doctor {

// Table of devices, findings, and a summary line.
std::string report_text(const Facts& facts, std::span<const CheckedFinding> findings);

// Members: version, commit, system, exit_status, devices, cuda_devices, findings (id, level, text, fix).
nlohmann::json report_json(const Facts& facts, std::span<const CheckedFinding> findings);

// Markdown with the text, the variables that matter, manifests and layers; redacted.
std::string report_file(const Facts& facts, std::span<const CheckedFinding> findings);

}  // namespace fire3dv::doctor
