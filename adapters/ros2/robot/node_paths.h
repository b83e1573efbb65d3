// Paths of the nodes of a glTF file, by which streams address the nodes of an added asset (SPEC.md, section
// 7).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>

namespace fire3dv::ros2 {

// Path of each node from the file's roots, by name; of several nodes of a name the first. Empty for bytes
// that are no GLB file.
std::unordered_map<std::string, std::string> node_paths(std::span<const uint8_t> glb);

}  // namespace fire3dv::ros2
