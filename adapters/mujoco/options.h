// Command line of fire3dv-mujoco.
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
  std::vector<std::filesystem::path>
      package_folders;  // folders that the model may read in addition to its own
  PublishOptions publish;
  std::vector<ImageSpec> images;
  std::filesystem::path out;  // image folder
  Drive drive = Drive::hold;
  double speed = 1;       // simulated seconds per second of wall time; 0: unlimited
  double duration_s = 0;  // simulated seconds; 0: until interrupted
  double ack_timeout_s = 60;
  bool paused = false, lockstep = false;
};

// Returns nothing when the program must exit with *exit_code: 0 after --help, 2 after a usage error. The text
// has been printed.
std::optional<Options> parse_options(int argc, char** argv, int* exit_code);

}  // namespace fire3dv::mujoco
