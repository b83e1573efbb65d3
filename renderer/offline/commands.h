// Commands `fire3dv render` and `fire3dv join`: their options and main functions.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "renderer/app/options/options.h"
#include "renderer/offline/timeline.h"

namespace fire3dv::offline {

// Video encoder settings.
struct VideoOptions {
  std::string codec;  // empty: default of the container
  std::optional<int> crf;
  bool full_chroma = false;
};

struct RenderOptions {
  std::string recording;
  app::Options drawing;  // scene, camera, size, device and appearance
  std::string look;      // those drawing options that affect pixels
  FrameRate rate;
  double start_s = 0;  // after the first frame of the recording
  std::optional<double> end_s;
  std::string clock;          // stream whose simulator time is used; empty: the first one's
  std::filesystem::path out;  // a video by its extension, else a folder
  bool resume = false;        // videos: via a frame folder
  uint32_t shard = 1, shards = 1;
  VideoOptions video;
};

struct JoinOptions {
  std::vector<std::filesystem::path> folders;
  std::filesystem::path out;
  VideoOptions video;
};

// Returns options or an exit code. argv[1] is the subcommand.
std::variant<RenderOptions, int> parse_render_options(int argc, char** argv);
std::variant<JoinOptions, int> parse_join_options(int argc, char** argv);

// `fire3dv render`: renders a recording to a video or to a frame folder. Returns the exit code.
int render(const RenderOptions& options);

// `fire3dv join`: merges the frames of shards into one video or one folder. It fails unless each frame exists
// exactly once and all shards have the same recording and settings. Returns the exit code.
int join(const JoinOptions& options);

// Encodes one complete frame folder, then deletes the files that fire3dv wrote there. Returns false if the
// user stopped it.
Result<bool> encode_and_clear(const std::filesystem::path& folder, const std::filesystem::path& out,
                              const VideoOptions& video);

}  // namespace fire3dv::offline
