// Environment variables that a report for an issue shows: those that decide about drivers, devices, folders
// and windows. All others may hold secrets.
#pragma once

#include <string>

#include "renderer/doctor/facts.h"

namespace fire3dv::doctor {

// Lines "NAME=value" of known variables that are set. A value that is neither a list of paths nor a plain
// word is described by its length alone.
std::string variable_lines(const Facts& facts);

// Replaces the values that variable_lines() does not show, and their parts, in a text that quotes them.
std::string without_hidden_values(std::string text, const Facts& facts);

}  // namespace fire3dv::doctor
