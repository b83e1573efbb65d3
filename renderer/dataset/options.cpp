#include "renderer/dataset/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/command_line.h"
#include "base/files.h"
#include "base/words.h"
#include "renderer/dataset/labels/description.h"
#include "renderer/dataset/layouts/layout.h"
#include "renderer/offline/drawing_words.h"
#include "renderer/offline/inputs/input_kind.h"
#include "renderer/sinks/video/video_file.h"

namespace fire3dv::dataset {
namespace {

constexpr const char* kCommand = "dataset";
constexpr std::array kWithValue{"--format",      "--out",   "--camera",   "--rate",        "--start",
                                "--end",         "--clock", "--object",   "--keypoints",   "--license",
                                "--depth-scale", "--shard", "--tar-size", "--flow-frames", "--randomize",
                                "--seed",        "--draws", "--images",   "--task"};
constexpr std::array kFlags{"--help", "-h", "--stereo-pairs", "--frame-motion"};
constexpr std::array kNotStored{"--out", "--keypoints", "--randomize", "--draws", "--shard", "--help", "-h"};
constexpr uint32_t kMaxFlowFrames = 1000;

// Name of an existing file or folder without the folders above it; other texts as they are.
std::string without_folders(const std::string& word) {
  std::error_code fault;
  const std::filesystem::path path(word);
  if (!std::filesystem::exists(path, fault) || !path.has_filename()) return word;
  return path.filename().string();
}

std::string formats_text() {
  std::string text = kFormats;
  std::replace(text.begin(), text.end(), '|', ' ');
  return text;
}

}  // namespace

std::string command_text(const char* command, int argc, char** argv) {
  constexpr std::array kTexts{"--format",  "--camera", "--object",  "--clock",
                              "--license", "--up",     "--prefix",  "--fixed-frame",
                              "--demo",    "--task",   "--episode", "--joint-unit"};
  std::string text = std::string("fire3dv ") + command;
  const std::vector<std::string> words =
      offline::without_machine_options(std::vector<std::string>(argv + 2, argv + argc));
  for (size_t i = 0; i < words.size(); ++i) {
    const size_t equals = words[i].starts_with("--") ? words[i].find('=') : std::string::npos;
    const std::string name = words[i].substr(0, equals);
    const bool has_value = equals != std::string::npos;
    if (name == "--shard" || name == "--out") {
      i += !has_value;
    } else if (std::find(kTexts.begin(), kTexts.end(), name) != kTexts.end()) {
      text += " " + shell_word(words[i]);
      if (!has_value && i + 1 < words.size()) text += " " + shell_word(words[++i]);
    } else if (has_value) {
      text += " " + shell_word(name + "=" + without_folders(words[i].substr(equals + 1)));
    } else {
      text += " " + shell_word(without_folders(words[i]));
    }
  }
  return text + " --out DIR";
}

bool is_own_option(std::string_view word) {
  const std::string_view name = word.substr(0, word.find('='));
  return name != "--out" && name != "--camera" &&
         std::find(kWithValue.begin(), kWithValue.end(), name) != kWithValue.end();
}

bool is_stored_option(std::string_view name) {
  const std::string word = "--" + std::string(name);
  const auto is_in = [&](const auto& list) {
    return std::find(list.begin(), list.end(), word) != list.end();
  };
  return (is_in(kWithValue) || is_in(kFlags)) && !is_in(kNotStored);
}

std::variant<DatasetOptions, int> parse_dataset_options(int argc, char** argv) {
  DatasetOptions options;
  CLI::App app{"Writes a labelled data set of a recording or a scene, in a format that trainers open."};
  app.name("fire3dv dataset");
  set_help(app, "RECORDING.mcap|SCENE [SCENE] --format FORMAT --out DIR [OPTIONS]");
  app.footer(
      "Options of images, drawing and devices are those of fire3dv. Details: man fire3dv-dataset, and\n"
      "docs/datasets.md.");
  set_program_flags(app);
  std::string rate, shard;
  std::optional<uint32_t> flow_frames;
  std::optional<uint64_t> seed;
  OptionGroup group(app);
  group.add_choice("--format", options.format, kFormats, "layout of the files");
  group.add("--out", options.run.out, "DIR", "folder of the data set; an interrupted run continues");
  group.add_repeatable("--camera", options.cameras, "NAME|auto", "camera by node or camera name; repeatable");
  group.add("--rate", rate, "RATE", "frames per second of simulated time (default: each recorded one)");
  group.add("--start", options.run.start_s, "SECONDS", "begin SECONDS after the first recorded frame");
  group.add("--end", options.run.end_s, "SECONDS", "end SECONDS after it; of an animated scene: its time");
  group.add("--clock", options.run.clock, "STREAM", "stream whose frames and time count (default: first)");
  group.add_repeatable("--object", options.objects, "NODE",
                       "label meshes of this node and below it alone; repeatable");
  group.add("--keypoints", options.keypoints, "FILE.json", "named points of nodes (see manual)");
  group.add("--license", options.license, "TEXT", "licence that the data set states");
  group.add("--depth-scale", options.depth_unit_mm, "MM", "unit of 16-bit depth images in millimetres");
  group.add("--task", options.task, "TEXT", "the task in words (lerobot)");
  group.add("--tar-size", options.tar_mb, "MB", "largest archive of webdataset (default 1000)");
  group.add("--flow-frames", flow_frames, "N",
            "optical flow to images N frames later and earlier (c3vd: 1, folder: 0)");
  group.add_flag("--stereo-pairs", options.is_stereo,
                 "cameras are left and right in turn: write disparity (folder)");
  group.add_flag("--frame-motion", options.run.frames_motion,
                 "the camera auto shows the scene over its whole motion");
  group.add("--randomize", options.randomize, "FILE.yaml", "draw parameters of each image from ranges");
  group.add("--seed", seed, "N", "seed of --randomize (default 0)");
  group.add("--draws", options.draws, "FILE.jsonl", "draws of a program, in place of those of the seed");
  group.add("--images", options.run.images, "N", "randomised images of each camera, of a scene at rest");
  group.add("--shard", shard, "I/N", "draw part I of N into a folder; fire3dv join merges them");
  offline::Words words = offline::split_words(argc, argv, kWithValue, kFlags);
  if (const auto exit_code = offline::parse_own_words(app, kCommand, words)) return *exit_code;
  const auto refuse = [](const std::string& text) { return offline::usage_error(kCommand, text); };
  if (words.rest.empty() || words.rest[0].empty() || words.rest[0].starts_with('-'))
    return refuse(
        "name a recording or a scene first: fire3dv dataset FILE.mcap|SCENE --format FORMAT --out DIR");
  if (options.format.empty()) return refuse("--format: name one of: " + formats_text());
  if (options.run.out.empty()) return refuse("--out: name a folder for the data set");
  if (const auto wrong = offline::find_wrong_inputs(kCommand, words.rest)) return refuse(*wrong);
  if (sinks::is_video_name(options.run.out) || lower_extension(options.run.out) == ".mcap")
    return refuse("--out " + options.run.out.string() + ": a data set is a folder: name one");
  if (offline::is_recording(words.rest[0])) {
    options.run.recording = words.rest[0];
    words.rest.erase(words.rest.begin());
  }
  auto drawing = offline::parse_drawing(kCommand, argv[0], std::move(words.rest));
  if (const int* exit_code = std::get_if<int>(&drawing)) return *exit_code;
  options.run.drawing = std::move(std::get<offline::Drawing>(drawing).options);
  options.run.look = std::move(std::get<offline::Drawing>(drawing).look);
  options.run.command = kCommand;
  options.run.own = offline::stored_options(words.own, kWithValue, is_stored_option);

  const bool is_scene = options.run.recording.empty();
  options.run.rate = is_scene ? std::optional(offline::FrameRate{}) : std::nullopt;
  if (!rate.empty()) {
    const auto parsed = offline::parse_frame_rate(rate);
    if (!parsed) return refuse(parsed.error().message);
    options.run.rate = *parsed;
  }
  const bool is_lerobot = options.format == kLerobot;
  if (is_lerobot && !options.run.rate) options.run.rate = offline::FrameRate{};
  if (is_lerobot && (options.run.rate->denominator != 1 || options.run.rate->numerator > kMaxFps))
    return refuse("--rate: lerobot takes a whole number of frames a second, at most " +
                  std::to_string(kMaxFps));
  if (const auto wrong = offline::check_range(options.run.start_s, options.run.end_s)) return refuse(*wrong);
  if (is_scene && !options.run.clock.empty()) return refuse("--clock is for recordings, and this is a scene");
  if (is_scene && options.run.drawing.animate.empty() && (options.run.end_s || options.run.start_s != 0))
    return refuse("--start and --end of a scene are times of an animation: choose one with --animate");
  if (!(options.depth_unit_mm >= 1e-4 && options.depth_unit_mm <= 1000))
    return refuse("--depth-scale must be a number of millimetres from 0.0001 to 1000");
  const auto names = [&](std::string_view option) {
    return std::any_of(words.own.begin(), words.own.end(),
                       [&](const std::string& word) { return word.substr(0, word.find('=')) == option; });
  };
  if (names("--task") && !is_lerobot) return refuse("--task is for --format lerobot");
  if (names("--tar-size") && options.format != "webdataset")
    return refuse("--tar-size is for --format webdataset");
  if (!(options.tar_mb >= 0.1 && options.tar_mb <= 1e6))
    return refuse("--tar-size must be a number of megabytes from 0.1 to 1000000");
  const bool has_flow_files = options.format == "c3vd" || options.format == "folder";
  options.flow_frames = flow_frames.value_or(options.format == "c3vd" ? 1 : 0);
  if (options.flow_frames > kMaxFlowFrames)
    return refuse("--flow-frames must be from 0 to " + std::to_string(kMaxFlowFrames));
  if (options.flow_frames != 0 && !has_flow_files)
    return refuse("--flow-frames: the format " + options.format +
                  " has no files for flow: choose c3vd or folder");
  if (options.is_stereo && options.format != "folder")
    return refuse("--stereo-pairs: the format " + options.format +
                  " has no files for disparity: choose folder");
  if (options.is_stereo && (options.cameras.empty() || options.cameras.size() % 2 != 0))
    return refuse("--stereo-pairs: name the cameras of each pair, as in --camera left --camera right");
  if (options.cameras.size() > offline::kMaxCameras)
    return refuse("--camera: " + std::to_string(offline::kMaxCameras) + " at most");
  if (options.randomize.empty() && !options.draws.empty())
    return refuse("--draws is for --randomize FILE.yaml, which has the parameters");
  if (options.randomize.empty() && seed) return refuse("--seed is for --randomize FILE.yaml");
  options.seed = seed.value_or(0);
  if (options.run.images) {
    if (options.randomize.empty())
      return refuse("--images is for --randomize FILE.yaml: all images of a scene at rest are the same");
    if (!is_scene || !options.run.drawing.animate.empty())
      return refuse("--images is for a scene at rest: choose times with --rate, --start and --end");
    if (*options.run.images < 1 || *options.run.images > offline::kMaxFrames)
      return refuse("--images must be from 1 to " + std::to_string(offline::kMaxFrames));
  }
  if (!shard.empty() && !offline::parse_shard(shard, options.run.shard, options.run.shards))
    return refuse("--shard " + shard + ": must be I/N with I from 1 to N, such as 1/8");
  options.has_depth_scale = names("--depth-scale");
  options.command = command_text(kCommand, argc, argv);
  return options;
}

}  // namespace fire3dv::dataset
