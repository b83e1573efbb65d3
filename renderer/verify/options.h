// Command line of `fire3dv verify`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace fire3dv::verify {

struct VerifyOptions {
  std::filesystem::path target;     // image, or folder of images
  std::filesystem::path recording;  // empty: not named
  std::filesystem::path scene;      // empty: not named
  std::optional<uint64_t> sample;   // number of images of a folder; nullopt: all
  std::vector<std::string> words;   // further options, for the command that draws
  std::string program;              // argv[0]
};

// Returns options or an exit code. argv[1] is the subcommand.
std::variant<VerifyOptions, int> parse_verify_options(int argc, char** argv);

}  // namespace fire3dv::verify
