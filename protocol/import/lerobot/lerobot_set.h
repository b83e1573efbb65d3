// LeRobot data set in a folder: its description, and the numbers of a column of an episode. Untrusted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/import/parquet/parquet_file.h"

namespace fire3dv::imported {

constexpr const char* kStateColumn = "observation.state";

struct LerobotInfo {
  int version = 3;  // 2: one file an episode
  double fps = 0;   // above 0
  uint64_t episodes = 0, chunk_files = 1000;
  std::vector<std::string> state_names;  // empty: none are given
};
Result<LerobotInfo> read_lerobot_info(const std::filesystem::path& folder);

// Rows of an episode, in order.
struct EpisodeRows {
  std::vector<double> frame_index;
  NumberRows state;
};
Result<EpisodeRows> read_episode(const std::filesystem::path& folder, const LerobotInfo& info,
                                 uint64_t episode);

}  // namespace fire3dv::imported
