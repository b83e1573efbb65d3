// Detection of description file formats by content, and guards for the XML parsers that read them afterwards.
// Those parsers recurse once per nested element.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "protocol/base/error.h"

namespace fire3dv::convert {

enum class DescriptionKind { adf, urdf, mjcf };

// Reads a description file of at most 64 MiB.
Result<std::string> read_text(const std::filesystem::path& file);

// The error names the file and, where known, its real format (xacro, SDF, glTF).
Result<DescriptionKind> kind_of(const std::filesystem::path& file, std::string_view text);

// Returns the name of the root element. Refuses more than 100 nested elements, entity definitions and
// constructs that parsers read differently. Empty: not XML. The error names the line.
Result<std::string> xml_root(std::string_view text);

}  // namespace fire3dv::convert
