// What a description is, by its first bytes; and guards for what reads XML after us. Libraries that read XML
// do it one call deeper for each element inside an element.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "protocol/error.h"

namespace fire3dv::convert {

enum class DescriptionKind { adf, urdf, mjcf };

// The whole text of a description's file, at most so many bytes.
Result<std::string> read_text(const std::filesystem::path& file);

// The error names the file and says what it is instead, where that is known (xacro, SDF, glTF).
Result<DescriptionKind> kind_of(const std::filesystem::path& file, std::string_view text);

// The name of the outermost element, once no element stands deeper than a hundred others, no entities are
// defined, and nothing is there that readers of XML read differently. Empty: no XML. The error names the
// line.
Result<std::string> xml_root(std::string_view text);

}  // namespace fire3dv::convert
