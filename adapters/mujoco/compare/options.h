// Command line of fire3dv-mujoco-compare.
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
  int frames = 8;                  // agreement: frames in total; speed: frames per block
  int blocks = 7;                  // speed: blocks per renderer, interleaved
  double every_s = 0.25;           // agreement: simulated seconds between frames
  double timeout_s = 60;           // per image
  std::filesystem::path pictures;  // agreement: folder for image pairs; empty: none
};

// Returns nothing when the program must exit with *exit_code: 0 after --help, 2 after a usage error. The text
// has been printed.
std::optional<CompareOptions> parse_compare_options(int argc, char** argv, int* exit_code);

}  // namespace fire3dv::mujoco
