// The command lines of `fire3dv render` and `fire3dv join`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "renderer/app/options.h"
#include "renderer/offline/frame_times.h"

namespace fire3dv::offline {

// How a video is encoded.
struct VideoOptions {
  std::string codec;  // empty: the container's usual one
  std::optional<int> crf;
  bool full_chroma = false;
};

struct RenderOptions {
  std::string recording;
  app::Options drawing;  // scene, camera, size, device, and how it looks
  std::string look;      // of those words, what decides about pixels
  FrameRate rate;
  double start_s = 0;  // after the first frame of the recording
  std::optional<double> end_s;
  std::string clock;          // stream whose simulated time counts; empty: the first one's
  std::filesystem::path out;  // a video by its ending, else a folder
  bool resume = false;        // videos: by way of a folder of frames
  uint32_t shard = 1, shards = 1;
  VideoOptions video;
};

struct JoinOptions {
  std::vector<std::filesystem::path> folders;
  std::filesystem::path out;
  VideoOptions video;
};

// Options, or the exit code with which the program ends now. argv[1] is the command.
std::variant<RenderOptions, int> parse_render_options(int argc, char** argv);
std::variant<JoinOptions, int> parse_join_options(int argc, char** argv);

}  // namespace fire3dv::offline
