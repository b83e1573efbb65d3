// Repair of DAE (COLLADA) texts in front of assimp, which refuses a whole file for a blank before a number.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fire3dv::convert {

struct RepairedDae {
  std::string text;
  std::vector<std::string> warnings;  // one line for each kind of value that is not as in the file
};

// Trims the text of elements, completes colours, and replaces numbers that are not finite: by the identity in
// transforms of nodes, else by "nan". Counts of arrays and primitives become those of their contents. UTF-16
// becomes UTF-8. What is no XML stays as it is.
RepairedDae repair_dae(std::string_view text);

}  // namespace fire3dv::convert
