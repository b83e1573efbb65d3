// Command line of fire3dv-ros2.
#pragma once

#include <fire3dv/client.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "adapters/ros2/dds/names.h"
#include "adapters/ros2/images/camera_options.h"
#include "adapters/ros2/markers/marker_input.h"
#include "adapters/ros2/tf/pose_sampler.h"

namespace fire3dv::ros2 {

struct Options {
  std::vector<std::string> uris;
  Security security;
  std::string scene_file;  // --write-scene; empty: the robot is added over the link
  std::vector<std::string> package_folders;
  bool reads_description = true;
  bool shows_joints = true;  // as scalars
  PoseSamplerOptions frames;
  ImageOptions images;
  MarkerTopics markers;
  std::optional<uint32_t> domain_id;
  Names names;
};

// Returns the options, or the exit code for a program that ends now (help, or a printed usage error).
std::variant<Options, int> parse_options(int argc, char** argv);

}  // namespace fire3dv::ros2
