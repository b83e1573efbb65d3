// Command lines of offline commands: options of the command itself, and all others for the renderer's parser.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "renderer/app/options/options.h"
#include "renderer/sinks/run_provenance.h"

namespace CLI {
class App;
}

namespace fire3dv::offline {

// Prints the error with a hint to the help of `fire3dv COMMAND`. Returns the exit code.
int usage_error(const char* command, const std::string& text);

// Words after argv[1]. own: of the options in with_value, each with its value, and of flags.
struct Words {
  std::vector<std::string> own, rest;
};
Words split_words(int argc, char** argv, std::span<const char* const> with_value,
                  std::span<const char* const> flags);

// Parses the command's own words. Returns the exit code after --help or a printed error.
std::optional<int> parse_own_words(CLI::App& app, const char* command, const Words& words);

// Options of the command itself that the provenance of images stores, without dashes; flags have an empty
// value.
sinks::RunProvenance::Values stored_options(const std::vector<std::string>& own,
                                            std::span<const char* const> with_value,
                                            bool (*is_stored)(std::string_view name));

// Parses the words of the renderer's options, without those that have no meaning offline. Returns them, or an
// exit code after a printed error.
struct Drawing {
  app::Options options;
  std::string look;  // words that affect pixels and that the manifest does not store otherwise
};
std::variant<Drawing, int> parse_drawing(const char* command, char* program, std::vector<std::string> words);

// Words without the options that differ between machines and affect no pixel: device, caches, checks.
std::vector<std::string> without_machine_options(std::span<const std::string> words);

// Parses "I/N" with I from 1 to N.
bool parse_shard(const std::string& text, uint32_t& index, uint32_t& count);

// Returns an error for times that are negative, too large, or in the wrong order.
std::optional<std::string> check_range(double start_s, const std::optional<double>& end_s);

}  // namespace fire3dv::offline
