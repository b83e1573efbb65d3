// Joint positions of an episode of a LeRobot data set (versions 2.0, 2.1 and 3.0), imported by the joints of
// a robot.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/error.h"
#include "protocol/import/import.h"
#include "protocol/record/mcap/file.h"
#include "protocol/robot/robot.h"

namespace fire3dv::imported {

struct LerobotChoices {
  std::optional<uint64_t> episode;  // nullopt: the only one
  std::string prefix;               // taken off the names of numbers; those without it are no joints
  bool in_degrees = false;          // angles of joints
};

// True for a folder with meta/info.json.
bool is_lerobot_set(const std::filesystem::path& folder);

// Numbers of the column observation.state move the joints of their names: as robot::position_names() has
// them, also with ".pos" behind. Numbers without names are all positions of the robot, in its order. Other
// joints keep their positions. Times are multiples of 1 / fps, from 0. The set is untrusted. on_progress: 0
// to 1; returning false ends the import.
Result<ImportReport> import_lerobot(const std::filesystem::path& folder, const LerobotChoices& choices,
                                    robot::Robot& robot, const std::function<bool(double)>& on_progress,
                                    std::unique_ptr<record::Sink> sink);

}  // namespace fire3dv::imported
