// Command line of `fire3dv dataset`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "renderer/offline/commands.h"

namespace fire3dv::dataset {

struct DatasetOptions {
  offline::RenderOptions run;  // recording, times, drawing, folder and shard
  std::string format;
  std::vector<std::string> cameras;  // empty: the scene's first, or one that frames it
  std::vector<std::string> objects;  // nodes; empty: all with triangles
  std::filesystem::path keypoints;   // side file; empty: none
  std::string license;
  double depth_unit_mm = 0.1;
  bool is_stereo = false;                // cameras are pairs with disparity
  uint32_t flow_frames = 0;              // flow to images so many frames later and earlier; 0: none
  std::string task = "recorded motion";  // lerobot
  double tar_mb = 1000;                  // most of an archive, in 10^6 bytes
  bool has_depth_scale = false;          // the command line names the unit
  std::filesystem::path randomize;       // randomisation file; empty: none
  uint64_t seed = 0;
  std::filesystem::path draws;  // draws in place of those of the seed; empty: none
  std::string command;          // the command line, without what differs between shards
};

// Command line for the README of a set: the same on all machines and for all parts, without shard, devices,
// caches and the folders of inputs, and with a placeholder for the set's.
std::string command_text(const char* command, int argc, char** argv);

// True for a word of a command line that is an option of `fire3dv dataset` itself, such as "--format=coco",
// and of no other command: not --out and --camera.
bool is_own_option(std::string_view word);

// True for an option of `fire3dv dataset` itself that is stored in the provenance: it names no file.
bool is_stored_option(std::string_view name);

// Returns options or an exit code. argv[1] is the subcommand.
std::variant<DatasetOptions, int> parse_dataset_options(int argc, char** argv);

}  // namespace fire3dv::dataset
