// Lines for people on the standard error.
#pragma once

#include <cstdio>
#include <string>

namespace fire3dv::mujoco {

// Names in it are a stranger's: nothing that a terminal would obey.
inline void say(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  std::fprintf(stderr, "fire3dv-mujoco: %s\n", text.c_str());
}

}  // namespace fire3dv::mujoco
