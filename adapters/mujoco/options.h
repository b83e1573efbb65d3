// The command line of fire3dv-mujoco.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "adapters/mujoco/publisher.h"
#include "adapters/mujoco/simulation.h"

namespace fire3dv::mujoco {

struct Options {
  std::string model, scene, keyframe;
  std::vector<std::filesystem::path> package_folders;  // what the model may read beside its own folder
  PublishOptions publish;
  std::vector<ImageWish> images;
  std::filesystem::path out;  // folder of the images
  Drive drive = Drive::hold;
  double speed = 1;       // simulated seconds a second; 0: as fast as can be
  double duration_s = 0;  // simulated; 0: until interrupted
  double ack_timeout_s = 60;
  bool paused = false, lockstep = false;
};

// Nothing: leave with *exit_code, which is 0 after --help and 2 after a mistake; the text has been printed.
std::optional<Options> parse_options(int argc, char** argv, int* exit_code);

}  // namespace fire3dv::mujoco
