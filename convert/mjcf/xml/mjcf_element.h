// Element tree of an MJCF model with its includes in place.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "convert/mjcf/xml/mjcf_files.h"

namespace fire3dv::convert {

struct MjcfElement {
  std::string kind;  // tag
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<MjcfElement> children;
  std::shared_ptr<const std::filesystem::path> file;
  int line = 0;

  const std::string* find(std::string_view attribute) const;
  // Value of an attribute, or "".
  std::string text(std::string_view attribute) const;
  // For messages: file, line, tag and name.
  std::string where() const;
};

// Limits: 2 million elements, 200 levels and 1000 files for one model with its includes. Includes are
// relative to the model's folder or to the file that includes them.
Result<MjcfElement> load_mjcf(const std::filesystem::path& file, MjcfFiles& files);

}  // namespace fire3dv::convert
