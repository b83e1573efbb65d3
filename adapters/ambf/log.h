// Log line of the plugin on stderr, prefixed `fire3dv:`. Safe for untrusted names.
#pragma once

#include <cstdio>
#include <string>

#include "protocol/wire/check.h"

namespace fire3dv::ambf {

// Replaces control characters, since messages quote names from files.
inline void log_line(const std::string& sentence) {
  std::fprintf(stderr, "fire3dv: warning: %s\n", wire::printable(sentence, 1000).c_str());
}

}  // namespace fire3dv::ambf
