// Edits of the text of an SDF document that keep its lines, so that libsdformat's messages name the right
// ones. The text has passed xml_root() and is well-formed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::convert {

// Replaces the URIs of <include> elements. replacements: one per <include>, in the order of the file; ""
// removes the element, none keeps it.
Result<std::string> with_include_uris(const std::string& text,
                                      const std::vector<std::optional<std::string>>& replacements);

// Replaces the version of the root element.
std::string with_sdf_version(std::string text, const std::string& version);

}  // namespace fire3dv::convert
