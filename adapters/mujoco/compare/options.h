// The command line of fire3dv-mujoco-compare.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "adapters/mujoco/compare/mujoco_renderer.h"

namespace fire3dv::mujoco {

struct CompareOptions {
  std::string model, uri;
  MujocoView view;
  bool speed = false;
  int frames = 8;                  // agree: how many; speed: in a block
  int blocks = 7;                  // speed: of each renderer, in turns
  double every_s = 0.25;           // agree: simulated seconds between frames
  double timeout_s = 60;           // for one image
  std::filesystem::path pictures;  // agree: a folder for them; empty: none
};

// Nothing: leave with *exit_code, which is 0 after --help and 2 after a mistake; the text has been printed.
std::optional<CompareOptions> parse_compare_options(int argc, char** argv, int* exit_code);

}  // namespace fire3dv::mujoco
