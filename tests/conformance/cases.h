// What the golden messages hold. Run tests/conformance/generate after a change; the files are committed.
#pragma once

#include <string>
#include <vector>

#include "protocol/wire/encode.h"

namespace fire3dv::conformance {

struct Case {
  std::string name;  // of the files data/NAME.bin and data/NAME.json
  wire::Bytes bytes;
  bool encodable = true;  // false: made by a later version, to be read only
  std::string refused;    // not empty: readers must refuse it with an error that holds this text
};

// Messages of this version, one for each message and feature.
std::vector<Case> cases_of_this_version();
// Messages of later versions: what the extension rule is about.
std::vector<Case> cases_of_later_versions();
// Messages whose structure is sound and whose values are not.
std::vector<Case> refused_cases();

// The same of scene edits and partial frames, since 1.1.
std::vector<Case> edit_cases();
std::vector<Case> later_edit_cases();
std::vector<Case> refused_edit_cases();

// The same of images, since 1.2.
std::vector<Case> image_cases();
std::vector<Case> refused_image_cases();

}  // namespace fire3dv::conformance
