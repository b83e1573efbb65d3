// Report of `fire3dv doctor` as text, as JSON, and as a file for an issue.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "renderer/doctor/check.h"

namespace fire3dv::doctor {

// Table of devices, findings, and a summary line.
std::string report_text(const Facts& facts, std::span<const CheckedFinding> findings);

// Members: version, commit, system, exit_status, devices, cuda_devices, findings (id, level, text, fix).
nlohmann::json report_json(const Facts& facts, std::span<const CheckedFinding> findings);

// Markdown with the text and the variables that matter. Not redacted.
std::string report_file(const Facts& facts, std::span<const CheckedFinding> findings);

// Words that name the user and the machine.
struct PrivateWords {
  std::vector<std::string> homes, users, hosts;
};
PrivateWords private_words(const Facts& facts);

// Replaces folders of users by "~", and names of users and of the host by "USER" and "HOST", as whole words.
std::string redacted(std::string text, const PrivateWords& words);

}  // namespace fire3dv::doctor
