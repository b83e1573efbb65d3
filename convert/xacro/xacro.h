// Expansion of xacro files to URDF, without ROS and without Python: properties, macros, blocks, includes,
// conditions, arguments and expressions (expression.h). The result is that of the program xacro; what is not
// supported is refused.
//
// Security: files are read only below the folders of the description, of its packages (by package.xml) and
// of --package-path. Environment variables are not read. Steps, text, nesting and files are limited (Budget).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "convert/model.h"
#include "convert/urdf_files.h"

namespace fire3dv::convert {

// True if the text has an element of xacro. Comments and CDATA sections may mention xacro.
bool has_xacro_element(std::string_view text);

struct ExpandedXacro {
  std::string text;
  std::vector<std::string> warnings;
};

// arguments: values of xacro:arg by name, also of the environment variables that $(env) and $(optenv) name.
// The error names file, line, element and, for what is not supported, the remedy.
Result<ExpandedXacro> expand_xacro(const std::filesystem::path& file, const std::string& text,
                                   const std::map<std::string, std::string>& arguments, UrdfFiles& files,
                                   Sources& sources);

}  // namespace fire3dv::convert
