// Draws that a program has made, in place of those of the randomisation: a file of JSON lines as frames.jsonl
// has them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "base/error.h"
#include "renderer/dataset/randomize/distribution.h"

namespace fire3dv::dataset {

struct GivenDraws {
  std::string file;                                              // for messages; empty: none are given
  std::string digest;                                            // of the file
  std::map<uint64_t, std::map<std::string, DrawnValue>> images;  // by image and parameter
};

// Lines {"frame": IMAGE, "drawn": {"NAME": VALUE}}; other members are ignored. Errors name the line.
Result<GivenDraws> read_given_draws(const std::filesystem::path& file);

}  // namespace fire3dv::dataset
