#include "renderer/relabel/options.h"

#include <CLI/CLI.hpp>
#include <array>
#include <utility>
#include <vector>

#include "base/command_line.h"
#include "base/files.h"
#include "renderer/offline/drawing_words.h"
#include "renderer/offline/inputs/input_kind.h"

namespace fire3dv::relabel {
namespace {

constexpr const char* kCommand = "relabel";
constexpr std::array kWithValue{"--out",  "--prefix",  "--fixed-frame", "--up",
                                "--demo", "--episode", "--joint-unit"};
constexpr std::array kFlags{"--help", "-h"};

// Folder "set/" has its recording beside it: "set.mcap".
std::filesystem::path recording_beside(const std::string& folder) {
  std::filesystem::path path = std::filesystem::path(folder).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  return path.string() + ".mcap";
}

}  // namespace

std::variant<RelabelOptions, int> parse_relabel_options(int argc, char** argv) {
  RelabelOptions options;
  CLI::App app{
      "Draws states that another program recorded, from new cameras and with labels, as a data set."};
  app.name("fire3dv relabel");
  set_help(app, "STATES SCENE --format FORMAT --out DIR|FILE.mcap [OPTIONS]");
  app.footer(
      "All options of fire3dv dataset apply, also --format. Details: man fire3dv-relabel, and\n"
      "docs/relabel.md.");
  set_program_flags(app);
  std::string out, up = "z", joint_unit = "rad";
  OptionGroup group(app);
  group.add("--out", out, "DIR|FILE.mcap", "data set, with its recording DIR.mcap; or a recording alone");
  group.add("--prefix", options.prefix, "TEXT", "beginning of the names of frames that nodes lack");
  group.add("--fixed-frame", options.fixed_frame, "FRAME", "frame at the scene's origin (see manual)");
  group.add("--demo", options.demo, "NAME", "demonstration of an HDF5 file, such as demo_0");
  group.add("--episode", options.episode, "N", "episode of a LeRobot data set, from 0");
  group.add_choice("--joint-unit", joint_unit, "rad|deg", "unit of joint angles");
  group.add_choice("--up", up, "z|y", "axis of the fixed frame that points up");
  offline::Words words = offline::split_words(argc, argv, kWithValue, kFlags);
  if (const auto exit_code = offline::parse_own_words(app, kCommand, words)) return *exit_code;
  const auto refuse = [](const std::string& text) { return offline::usage_error(kCommand, text); };
  if (words.rest.empty() || words.rest[0].empty() || words.rest[0].starts_with('-'))
    return refuse(
        "name a recording and a scene first: fire3dv relabel STATES SCENE --format FORMAT --out DIR");
  if (out.empty()) return refuse("--out: name a folder for the data set, or FILE.mcap for a recording alone");
  if (const auto wrong = offline::find_wrong_inputs(kCommand, words.rest)) return refuse(*wrong);
  options.states = words.rest[0];
  options.is_z_up = up == "z";
  options.in_degrees = joint_unit == "deg";
  words.rest.erase(words.rest.begin());

  if (lower_extension(out) == ".mcap") {
    options.recording = out;
    for (const std::string& word : words.rest) {
      if (dataset::is_own_option(word))
        return refuse(word.substr(0, word.find('=')) + " is for a data set, and --out " + out +
                      " names a recording alone: name a folder with --out, or leave that option out");
    }
    auto drawing = offline::parse_drawing(kCommand, argv[0], std::move(words.rest));
    if (const int* exit_code = std::get_if<int>(&drawing)) return *exit_code;
    options.drawing = std::move(std::get<offline::Drawing>(drawing).options);
  } else {
    options.recording = recording_beside(out);
    std::vector<std::string> rest{argv[0], "dataset", options.recording.string()};
    rest.insert(rest.end(), words.rest.begin(), words.rest.end());
    rest.insert(rest.end(), {"--out", out, "--frame-motion"});
    std::vector<char*> pointers;
    for (std::string& word : rest) pointers.push_back(word.data());
    auto dataset = dataset::parse_dataset_options(static_cast<int>(pointers.size()), pointers.data());
    if (const int* exit_code = std::get_if<int>(&dataset)) return *exit_code;
    options.dataset = std::move(std::get<dataset::DatasetOptions>(dataset));
    options.dataset->command = dataset::command_text(kCommand, argc, argv);
    options.drawing = options.dataset->run.drawing;
  }
  if (options.drawing.scene.empty())
    return refuse("name the scene after the states: fire3dv relabel " + options.states.string() +
                  " SCENE --out " + out);
  return options;
}

}  // namespace fire3dv::relabel
