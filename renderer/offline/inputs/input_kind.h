// Kinds of input files, by name and first bytes, for errors that name the right command.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fire3dv::offline {

enum class InputKind : uint8_t {
  unknown,    // also: there is no such file
  recording,  // MCAP, of this program or another
  states,     // of other programs: HDF5, SQLite, folders of ROS 2 bags and LeRobot
  scene,      // glTF, or a description or mesh file that is converted
};
InputKind find_input_kind(const std::filesystem::path& path);

// True for a file that is a recording (MCAP), by its name or its first bytes.
bool is_recording(const std::filesystem::path& path);

// Error for a command that takes a recording, or a scene, first: names of other kinds, or in another order.
// words: names and options that follow the command. nullopt: no fault is seen.
std::optional<std::string> find_wrong_inputs(const std::string& command,
                                             const std::vector<std::string>& words);

}  // namespace fire3dv::offline
