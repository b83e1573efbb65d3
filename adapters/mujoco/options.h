// Command line of fire3dv-mujoco, with the names of image outputs and cameras.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "adapters/mujoco/publisher.h"
#include "adapters/mujoco/simulation.h"
#include "base/error.h"

namespace fire3dv::mujoco {

// Parses "color,depth" to FIRE3DV_IMAGE_* bits. The error lists valid names.
Result<uint32_t> image_outputs(std::string_view text);

// Parses "CAMERA" or "CAMERA:320x240". Camera names may contain colons.
Result<ImageSpec> image_spec(const std::string& text);

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
  bool controls = false;  // people may run, pause, drag, and move actuators
};

// Returns nothing when the program must exit with *exit_code: 0 after --help, 2 after a usage error. The text
// has been printed.
std::optional<Options> parse_options(int argc, char** argv, int* exit_code);

}  // namespace fire3dv::mujoco
