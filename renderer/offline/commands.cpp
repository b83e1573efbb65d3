#include "renderer/offline/commands.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <memory>
#include <string_view>
#include <tuple>

#include "base/command_line.h"
#include "renderer/offline/drawing_words.h"
#include "renderer/offline/inputs/input_kind.h"
#include "renderer/sinks/video/video_file.h"

namespace fire3dv::offline {
namespace {

// Options of this command; all others are renderer options.
constexpr std::array kWithValue{"--fps", "--start",   "--end",   "--clock", "--out",
                                "--crf", "--outputs", "--shard", "--codec"};
constexpr std::array kStored{"--fps", "--start",       "--end",     "--clock",       "--codec",
                             "--crf", "--full-chroma", "--outputs", "--frame-motion"};
constexpr std::array kFlags{"--resume", "--full-chroma", "--frame-motion", "--help", "-h"};

void add_video_options(CLI::App& app, VideoOptions& video) {
  OptionGroup group(app, "Video");
  group.add("--codec", video.codec, "NAME",
            "h264 (default), h265, av1 (default of .webm), or lossless ffv1 (.mkv)");
  group.add("--crf", video.crf, "N", "quality: 0 is best; h264 and h265 to 51, av1 to 63");
  group.add_flag("--full-chroma", video.full_chroma, "4:4:4 chroma, which few players decode");
}

std::optional<std::string> check_out(const std::filesystem::path& out, const VideoOptions& video) {
  if (out.empty()) return "--out: name a video (.mp4, .mkv, .webm) or a folder";
  if (sinks::is_foreign_video_name(out))
    return "--out " + out.string() + ": videos are written as .mp4, .mkv or .webm";
  const bool encodes = !video.codec.empty() || video.crf || video.full_chroma;
  if (encodes && !sinks::is_video_name(out))
    return "--codec, --crf and --full-chroma are for videos, and --out " + out.string() + " is a folder";
  return {};
}

}  // namespace

bool is_stored_option(std::string_view name) {
  return std::find(kStored.begin(), kStored.end(), "--" + std::string(name)) != kStored.end();
}

std::variant<RenderOptions, int> parse_render_options(int argc, char** argv) {
  RenderOptions options;
  CLI::App app{"Renders a recording: each frame of the video once, at its simulated time."};
  app.name("fire3dv render");
  set_help(app, "FILE.mcap [SCENE] --out VIDEO|DIR [OPTIONS]");
  app.footer("Options of images, drawing and devices are those of fire3dv. Details: man fire3dv-render.");
  set_program_flags(app);
  std::string fps = "30", shard, outputs;
  OptionGroup group(app);
  group.add("--out", options.out, "VIDEO|DIR", "video (.mp4, .mkv, .webm), or folder of PNG files");
  group.add("--fps", fps, "RATE", "frames per second of simulated time, also 30000/1001");
  group.add("--start", options.start_s, "SECONDS", "begin SECONDS after the first recorded frame");
  group.add("--end", options.end_s, "SECONDS", "end SECONDS after it (default: last frame)");
  group.add("--clock", options.clock, "STREAM",
            "stream whose simulated time the video follows (default: first)");
  group.add("--outputs", outputs, "LIST", "images to write into a folder (default: color; see manual)");
  group.add("--shard", shard, "I/N", "render part I of N into a folder; fire3dv join merges them");
  group.add_flag("--frame-motion", options.frames_motion,
                 "the camera auto shows the scene over its whole motion");
  group.add_flag("--resume", options.resume, "keep finished frames, so that an interrupted run continues");
  add_video_options(app, options.video);
  Words words = split_words(argc, argv, kWithValue, kFlags);
  if (const auto exit_code = parse_own_words(app, "render", words)) return *exit_code;
  const auto refuse = [](const std::string& text) { return usage_error("render", text); };
  if (words.rest.empty() || words.rest[0].starts_with('-'))
    return refuse("name the recording first: fire3dv render FILE.mcap [SCENE] --out VIDEO|DIR");
  if (const auto wrong = find_wrong_inputs("render", words.rest)) return refuse(*wrong);
  options.recording = words.rest[0];
  words.rest.erase(words.rest.begin());

  auto drawing = parse_drawing("render", argv[0], std::move(words.rest));
  if (const int* exit_code = std::get_if<int>(&drawing)) return *exit_code;
  options.drawing = std::move(std::get<Drawing>(drawing).options);
  options.look = std::move(std::get<Drawing>(drawing).look);
  options.own = stored_options(words.own, kWithValue, is_stored_option);

  const auto rate = parse_frame_rate(fps);
  if (!rate) return refuse(rate.error().message);
  options.rate = *rate;
  if (const auto wrong = check_range(options.start_s, options.end_s)) return refuse(*wrong);
  if (const auto wrong = check_out(options.out, options.video)) return refuse(*wrong);
  const bool is_video = sinks::is_video_name(options.out);
  if (!outputs.empty()) {
    const auto parsed = wire::parse_image_outputs(outputs);
    if (!parsed) return refuse("--outputs: " + parsed.error().message);
    if (is_video) return refuse("--outputs are written as files: name a folder with --out");
    options.drawing.outputs = *parsed;
    if (options.drawing.markers_in_data_sets && parsed->has(wire::kColorLinearF16))
      return refuse("--outputs: linear shows no markers; leave it or --markers all out");
  }
  if (!shard.empty()) {
    if (!parse_shard(shard, options.shard, options.shards))
      return refuse("--shard " + shard + ": must be I/N with I from 1 to N, such as 1/8");
    if (is_video)
      return refuse(
          "--shard writes frames without loss: name a folder with --out, and fire3dv join makes the video");
  }
  if (options.resume && !is_video)
    return refuse("--resume is for videos; a folder of frames is gone on with in any case");
  return options;
}

std::variant<JoinOptions, int> parse_join_options(int argc, char** argv) {
  JoinOptions options;
  CLI::App app{
      "Puts the frames of fire3dv render --shard together, after a check that each is there exactly once."};
  app.name("fire3dv join");
  set_help(app, "DIR... --out VIDEO|DIR [OPTIONS]");
  set_program_flags(app);
  app.add_option("folders", options.folders, "what the shards wrote, in any order")->required();
  app.add_option("--out", options.out, "a video (.mp4, .mkv, .webm), or a folder for all frames");
  add_video_options(app, options.video);
  try {
    app.parse(argc - 1, argv + 1);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    return usage_error("join", usage_text(app, error));
  }
  if (const auto wrong = check_out(options.out, options.video)) return usage_error("join", *wrong);
  return options;
}

}  // namespace fire3dv::offline
