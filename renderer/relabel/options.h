// Command line of `fire3dv relabel`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "renderer/app/options/options.h"
#include "renderer/dataset/options.h"

namespace fire3dv::relabel {

struct RelabelOptions {
  std::filesystem::path states;     // recording of another program
  std::filesystem::path recording;  // written by the import
  std::string prefix, fixed_frame;
  std::string demo;                 // of an HDF5 file; empty: the only one
  std::optional<uint64_t> episode;  // of a LeRobot data set; nullopt: the only one
  bool in_degrees = false;          // angles of joint states and LeRobot data sets
  bool is_z_up = true;
  app::Options drawing;                            // with the scene
  std::optional<dataset::DatasetOptions> dataset;  // nothing: the recording alone is written
};

// Returns options or an exit code. argv[1] is the subcommand.
std::variant<RelabelOptions, int> parse_relabel_options(int argc, char** argv);

}  // namespace fire3dv::relabel
