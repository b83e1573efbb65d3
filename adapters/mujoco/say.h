// Log line of fire3dv-mujoco on standard error. Safe for untrusted names.
#pragma once

#include <cstdio>
#include <string>

namespace fire3dv::mujoco {

// Replaces control characters, since names in `text` are untrusted.
inline void say(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  std::fprintf(stderr, "fire3dv-mujoco: %s\n", text.c_str());
}

}  // namespace fire3dv::mujoco
