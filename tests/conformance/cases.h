// Golden messages of the conformance suite. After a change run tests/conformance/generate and commit the
// files.
#pragma once

#include <string>
#include <vector>

#include "protocol/wire/encode.h"

namespace fire3dv::conformance {

struct Case {
  std::string name;  // stem of the files data/NAME.bin and data/NAME.json
  wire::Bytes bytes;
  bool encodable = true;  // false: a message of a later version, for decoding only
  std::string refused;    // not empty: readers must refuse the message with an error that contains this text
};

// Messages of this version: one for each message type and feature.
std::vector<Case> cases_of_this_version();
// Messages of later versions, for the extension rule of SPEC.md.
std::vector<Case> cases_of_later_versions();
// Structurally valid messages with invalid values.
std::vector<Case> refused_cases();

// The same for scene edits and partial frames, since 1.1.
std::vector<Case> edit_cases();
std::vector<Case> later_edit_cases();
std::vector<Case> refused_edit_cases();

// The same for inputs and their events, since 1.10.
std::vector<Case> input_cases();
std::vector<Case> later_input_cases();
std::vector<Case> refused_input_cases();

// The same for images, since 1.2.
std::vector<Case> scalar_cases();
std::vector<Case> refused_scalar_cases();
std::vector<Case> image_cases();
std::vector<Case> refused_image_cases();

}  // namespace fire3dv::conformance
