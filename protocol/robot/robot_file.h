// Reader of the joints of a glTF file (docs/joints.md). The file is untrusted: sizes, depth, references and
// numbers are checked.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>

#include "base/error.h"
#include "protocol/robot/robot.h"

namespace fire3dv::robot {

// follows_mimic: false makes joints that mimic others independent.
Result<Robot> read_robot(std::span<const std::byte> glb_or_json, bool follows_mimic);
// Reads the JSON of the file only. Errors name the file.
Result<Robot> read_robot_file(const std::filesystem::path& file, bool follows_mimic);
// The same; empty: the file holds no robot, or its JSON is larger than 64 MiB.
Result<std::optional<Robot>> find_robot(const std::filesystem::path& file, bool follows_mimic);

}  // namespace fire3dv::robot
