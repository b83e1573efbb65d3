#include "renderer/verify/options.h"

#include <CLI/CLI.hpp>
#include <array>
#include <utility>

#include "base/command_line.h"
#include "renderer/offline/drawing_words.h"
#include "renderer/offline/inputs/input_kind.h"

namespace fire3dv::verify {
namespace {

constexpr const char* kCommand = "verify";
constexpr std::array kWithValue{"--sample"};
constexpr std::array kFlags{"--help", "-h", "--version"};

}  // namespace

std::variant<VerifyOptions, int> parse_verify_options(int argc, char** argv) {
  VerifyOptions options;
  options.program = argv[0];
  CLI::App app{"Draws stored images again, and names the first difference."};
  app.name("fire3dv verify");
  set_help(app, "IMAGE.png|DIR|VIDEO [RECORDING.mcap] [SCENE] [OPTIONS]");
  app.footer(
      "Options of images, drawing and devices are those of fire3dv; without them, those of the images are\n"
      "used. Exit status: 0 identical, 1 different, 2 cannot be checked. Details: man fire3dv-verify.");
  set_program_flags(app);
  OptionGroup group(app);
  group.add("--sample", options.sample, "N", "check N images of a folder, evenly spread (default: all)")
      ->check(in_range(uint64_t{1}, uint64_t{1} << 40));
  offline::Words words = offline::split_words(argc, argv, kWithValue, kFlags);
  if (const auto exit_code = offline::parse_own_words(app, kCommand, words)) return *exit_code;
  auto word = words.rest.begin();
  const auto next_name = [&]() -> std::optional<std::string> {
    if (word == words.rest.end() || word->empty() || word->starts_with('-')) return std::nullopt;
    return *word++;
  };
  const auto target = next_name();
  if (!target)
    return offline::usage_error(
        kCommand, "name an image or a folder first: fire3dv verify IMAGE.png|DIR [RECORDING.mcap] [SCENE]");
  options.target = *target;
  while (const auto name = next_name()) {
    auto& path = offline::is_recording(*name) ? options.recording : options.scene;
    if (!path.empty())
      return offline::usage_error(kCommand, "two names, " + path.string() + " and " + *name +
                                                ": one recording and one scene at most");
    path = *name;
  }
  options.words.assign(word, words.rest.end());
  return options;
}

}  // namespace fire3dv::verify
