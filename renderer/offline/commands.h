// Commands `fire3dv render` and `fire3dv join`: their options and main functions, also for `fire3dv dataset`.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "renderer/app/options/options.h"
#include "renderer/offline/frame_format.h"
#include "renderer/offline/image_consumer.h"
#include "renderer/offline/image_set.h"
#include "renderer/offline/timeline.h"
#include "renderer/sinks/run_provenance.h"

namespace fire3dv::offline {

// Video encoder settings.
struct VideoOptions {
  std::string codec;  // empty: default of the container
  std::optional<int> crf;
  bool full_chroma = false;
};

struct RenderOptions {
  std::string command = "render";               // for the provenance of images
  sinks::RunProvenance::Values own;             // options of the command itself, without files; also for it
  std::string recording;                        // empty: the scene at rest; `fire3dv dataset` only
  app::Options drawing;                         // scene, camera, size, device and appearance
  std::string look;                             // those drawing options that affect pixels
  std::optional<FrameRate> rate = FrameRate{};  // nullopt: each recorded frame
  // In place of rate, start_s and end_s, of a recording. Null: none.
  std::function<Result<FrameTimes>(const Timeline& timeline)> choose_times;
  double start_s = 0;  // after the first frame of the recording
  std::optional<double> end_s;
  std::optional<uint64_t> images;  // frames of a scene at rest; nullopt: one
  bool frames_motion = false;      // the camera auto shows the scene over the whole recording
  std::string clock;               // stream whose simulator time is used; empty: the first one's
  std::filesystem::path out;       // a video by its extension, else a folder
  bool resume = false;             // videos: via a frame folder
  uint32_t shard = 1, shards = 1;
  VideoOptions video;
};

struct JoinOptions {
  std::vector<std::filesystem::path> folders;
  std::filesystem::path out;
  VideoOptions video;
};

// True for an option of `fire3dv render` itself that is stored in the provenance: it names no file.
bool is_stored_option(std::string_view name);

// Returns options or an exit code. argv[1] is the subcommand.
std::variant<RenderOptions, int> parse_render_options(int argc, char** argv);
std::variant<JoinOptions, int> parse_join_options(int argc, char** argv);

// `fire3dv render`: renders a recording to a video or to a frame folder. Returns the exit code. set: not null
// for data sets, into a folder. consumer: not null in place of options.out.
int render(const RenderOptions& options, ImageSet* set, ImageConsumer* consumer = nullptr);
inline int render(const RenderOptions& options) {
  return render(options, nullptr);
}

// `fire3dv join`: merges the frames of shards into one video or one folder. It fails unless each frame exists
// exactly once and all shards have the same recording and settings. Returns the exit code.
// find_format: format of the folders; a null one: colours alone.
using FindFormat =
    std::function<Result<std::shared_ptr<FrameFormat>>(const std::vector<std::filesystem::path>& folders)>;
int join(const JoinOptions& options, const FindFormat& find_format);

// Encodes one complete frame folder, then deletes the files that fire3dv wrote there. Returns false if the
// user stopped it.
Result<bool> encode_and_clear(const std::filesystem::path& folder, const std::filesystem::path& out,
                              const VideoOptions& video);

}  // namespace fire3dv::offline
