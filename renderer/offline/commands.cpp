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
#include "base/numbers.h"
#include "renderer/sinks/video/video_file.h"

namespace fire3dv::offline {
namespace {

constexpr int kUsageError = 2;
constexpr uint32_t kMaxShards = 100'000;

int usage_error(const char* command, const std::string& text) {
  std::cerr << "fire3dv " << command << ": error: " << text << " (see fire3dv " << command << " --help)\n";
  return kUsageError;
}

// Options of this command; all others are renderer options.
constexpr std::array kWithValue{"--fps", "--start", "--end",   "--clock",
                                "--out", "--shard", "--codec", "--crf"};
constexpr std::array kFlags{"--resume", "--full-chroma", "--help", "-h"};

// Renderer options that do not affect pixels, or that the manifest stores otherwise.
constexpr std::array kNeutralWithValue{"--cache", "--device",      "--async-compute",
                                       "--size",  "--environment", "--checkpoint"};
constexpr std::array kNeutralFlags{"--validation", "--no-validation", "--headless", "--require-gpu"};

template <typename List>
bool contains(const List& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

struct Words {
  std::vector<std::string> own, rest;
};
Words split(int argc, char** argv) {
  Words words;
  for (int i = 2; i < argc; ++i) {
    const std::string_view word = argv[i];
    const std::string_view name = word.substr(0, word.find('='));
    const bool has_value = contains(kWithValue, name);
    if (!has_value && !contains(kFlags, word)) {
      words.rest.emplace_back(word);
      continue;
    }
    words.own.emplace_back(word);
    if (has_value && name == word && i + 1 < argc) words.own.emplace_back(argv[++i]);
  }
  return words;
}

std::string look_of(const std::vector<std::string>& words, const std::string& scene) {
  std::string look;
  bool scene_seen = scene.empty();
  for (size_t i = 0; i < words.size(); ++i) {
    const std::string_view word = words[i];
    const std::string_view name = word.substr(0, word.find('='));
    if (contains(kNeutralWithValue, name)) {
      if (name == word) ++i;
    } else if (!contains(kNeutralFlags, word)) {
      if (!scene_seen && word == scene) {
        scene_seen = true;
        continue;
      }
      look += (look.empty() ? "" : " ") + words[i];
    }
  }
  std::replace(look.begin(), look.end(), '=', ' ');
  return look;
}

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

bool parse_shard(const std::string& text, uint32_t& index, uint32_t& count) {
  const auto parts = parse_pair<uint32_t>(text, '/');
  if (!parts) return false;
  std::tie(index, count) = *parts;
  return index >= 1 && index <= count && count <= kMaxShards;
}

std::string for_live_streams(const std::string& option) {
  return option + " is for streams that are live; a recording is rendered without";
}

// Rejects options for which the renderer's parser has no or a misleading error.
std::optional<std::string> check_words(const std::vector<std::string>& words) {
  constexpr std::array kLive{"--play", "--delay", "--mark-held", "--on-request"};
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    if (contains(kLive, name)) return for_live_streams(name);
    if (name == "--outputs")
      return "--outputs: fire3dv render writes colours alone; others are written by fire3dv --replay "
             "FILE.mcap --out DIR --outputs LIST";
  }
  return {};
}

// Rejects renderer options that have no meaning offline.
std::optional<std::string> check_drawing(const app::Options& drawing) {
  const auto none = for_live_streams;
  if (!drawing.listen.empty()) return none("--listen");
  if (!drawing.recording.replay.empty() || !drawing.recording.streams.empty() || drawing.recording.loop)
    return "--replay, --stream and --loop are for watching a recording; the one to render is named first";
  if (!drawing.recording.record.empty()) return none("--record");
  if (drawing.lockstep) return none("--lockstep");
  if (!drawing.devices.empty())
    return "--devices spreads images that simulators ask for: name one with --device, and draw a part on "
           "each "
           "with --shard";
  if (!drawing.metrics.empty()) return none("--metrics");
  if (!drawing.serve.empty()) return none("--serve");
  if (drawing.exit_when_done) return none("--exit-when-done");
  if (drawing.frames != 0) return "--frames: choose a part with --start and --end";
  if (!drawing.stats.empty()) return none("--stats");
  if (drawing.list_devices) return "--list-devices is an option of fire3dv alone";
  return {};
}

}  // namespace

std::variant<RenderOptions, int> parse_render_options(int argc, char** argv) {
  RenderOptions options;
  CLI::App app{"Renders a recording: each frame of the video once, at its simulated time."};
  app.name("fire3dv render");
  set_help(app, "FILE.mcap [SCENE] --out VIDEO|DIR [OPTIONS]");
  app.footer("Options of images, drawing and devices are those of fire3dv. Details: man fire3dv-render.");
  set_program_flags(app);
  std::string fps = "30", shard;
  OptionGroup group(app);
  group.add("--out", options.out, "VIDEO|DIR", "video (.mp4, .mkv, .webm), or folder of PNG files");
  group.add("--fps", fps, "RATE", "frames per second of simulated time, also 30000/1001");
  group.add("--start", options.start_s, "SECONDS", "begin SECONDS after the first recorded frame");
  group.add("--end", options.end_s, "SECONDS", "end SECONDS after it (default: last frame)");
  group.add("--clock", options.clock, "STREAM",
            "stream whose simulated time the video follows (default: first)");
  group.add("--shard", shard, "I/N", "render part I of N into a folder; fire3dv join merges them");
  group.add_flag("--resume", options.resume, "keep finished frames, so that an interrupted run continues");
  add_video_options(app, options.video);
  Words words = split(argc, argv);
  try {
    std::vector<std::string> reversed(words.own.rbegin(), words.own.rend());
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    return usage_error("render", usage_text(app, error));
  }
  const auto refuse = [](const std::string& text) { return usage_error("render", text); };
  if (words.rest.empty() || words.rest[0].starts_with('-'))
    return refuse("name the recording first: fire3dv render FILE.mcap [SCENE] --out VIDEO|DIR");
  options.recording = words.rest[0];
  words.rest.erase(words.rest.begin());

  if (const auto wrong = check_words(words.rest)) return refuse(*wrong);
  std::vector<char*> drawing{argv[0]};
  for (std::string& word : words.rest) drawing.push_back(word.data());
  auto parsed = app::parse_options(static_cast<int>(drawing.size()), drawing.data(), false);
  if (const int* exit_code = std::get_if<int>(&parsed)) return *exit_code;
  options.drawing = std::move(std::get<app::Options>(parsed));
  options.drawing.headless = true;
  if (const auto wrong = check_drawing(options.drawing)) return refuse(*wrong);
  options.look = look_of(words.rest, options.drawing.scene.string());

  const auto rate = parse_frame_rate(fps);
  if (!rate) return refuse(rate.error().message);
  options.rate = *rate;
  constexpr double kMaxSeconds = 1e9;
  if (!(options.start_s >= 0 && options.start_s <= kMaxSeconds))
    return refuse("--start must be a number from 0 to 1e9");
  if (options.end_s && !(*options.end_s >= options.start_s && *options.end_s <= kMaxSeconds))
    return refuse("--end must be a number from that of --start to 1e9");
  if (const auto wrong = check_out(options.out, options.video)) return refuse(*wrong);
  const bool is_video = sinks::is_video_name(options.out);
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
