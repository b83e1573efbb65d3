// What the plugin says to people, among AMBF's own lines on stderr.
#pragma once

#include <cstdio>
#include <string>

#include "protocol/wire/check.h"

namespace fire3dv::ambf {

// Never bytes that move a cursor: sentences quote names out of files.
inline void tell(const std::string& sentence) {
  std::fprintf(stderr, "fire3dv: %s\n", wire::printable(sentence, 1000).c_str());
}

}  // namespace fire3dv::ambf
