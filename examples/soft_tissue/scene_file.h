// Scene of the example: drape, lamps, cameras, instruments, and the phantom twice: while the vertices of one
// copy are replaced, the other one is shown.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "examples/soft_tissue/phantom.h"
#include "examples/soft_tissue/simulation.h"

namespace soft_tissue {

// Nodes that move, in the order of the stream: the instruments, then both copies of the phantom, then those
// of the square of --frame-code.
constexpr size_t kInstruments = 4;
std::vector<std::string> body_names(bool frame_code);
constexpr const char* kTissue[] = {"tissue a", "tissue b"};
constexpr const char* kCode[] = {"frame code a", "frame code b"};

// Pose of a copy that is shown, moved by an offset, or hidden: below the drape.
std::array<float, 12> copy_pose(bool shown, const std::array<float, 3>& offset);

// Returns an error message, or nothing on success. frame_code: with both copies of the square.
std::optional<std::string> write_scene(const Simulation& simulation, bool frame_code,
                                       const std::string& path);

// Corners of the square, which lie the other way from where a pose with this offset moves it.
std::vector<float> code_corners(const std::array<float, 3>& offset);

}  // namespace soft_tissue
