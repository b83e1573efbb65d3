#include <algorithm>
#include <cstdio>
#include <utility>

#include "base/files.h"
#include "renderer/dataset/layouts/image_files.h"
#include "renderer/dataset/layouts/layouts.h"
#include "renderer/dataset/lerobot/depth_codes.h"
#include "renderer/dataset/lerobot/tables.h"
#include "renderer/dataset/lerobot/videos.h"

namespace fire3dv::dataset {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImagesFolder = "images/";  // LeRobot's upload leaves it out
constexpr uint32_t kMinSide = 16;                 // of H.265

// Images lie in images/, from which pack() makes videos; they stay, since videos lose colours.
class LerobotLayout final : public Layout {
 public:
  Result<void> check(const Description& description) const override;
  std::optional<Depth16> depth16(const Description& description) const override {
    return Depth16{DepthCodes::of(description).max_m * kMillimetres / UINT16_MAX,
                   "4095 there; --depth-scale chooses another range"};
  }
  std::vector<std::string> folders(const Description& description) const override;
  std::string color_name(const Description& description, uint64_t image) const override;
  std::vector<std::string> file_names(const Description& description, uint64_t image, size_t) const override {
    return {color_name(description, image), depth_name(*this, description, image)};
  }
  Result<std::vector<std::vector<uint8_t>>> encode(const Description& description,
                                                   const sinks::FrameImage& image, const ImageLabels& labels,
                                                   std::vector<uint8_t> color) const override;
  // Tables count the packets of the videos.
  Result<void> pack(const fs::path& folder, const Description& description,
                    const offline::FrameLines& lines) const override;
  Result<std::vector<offline::FolderFile>> list_files(const Description&,
                                                      const offline::FrameLines&) const override {
    return std::vector<offline::FolderFile>();
  }
  std::vector<std::string> unlisted_names() const override { return {"data/", "meta/", "videos/"}; }
  std::string conventions(const Description& description) const override;
};

std::string shortest(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

Result<void> LerobotLayout::check(const Description& description) const {
  if (description.episode.fps == 0) return Error{"a LeRobot data set has frames a second: run it again"};
  if (description.width % 2 != 0 || description.height % 2 != 0 ||
      std::min(description.width, description.height) < kMinSide)
    return Error{"videos of --format lerobot have an even number of pixels on each side, and at least " +
                 std::to_string(kMinSide) + ", not " + std::to_string(description.width) + "x" +
                 std::to_string(description.height) + ": choose another --size"};
  for (const bool is_depth : {false, true}) {
    if (auto good = sinks::check_video_settings(video_settings(description, "file-000.mp4", is_depth)); !good)
      return Error{"--format lerobot: " + good.error().message};
  }
  return {};
}

std::vector<std::string> LerobotLayout::folders(const Description& description) const {
  std::vector<std::string> folders{fs::path(kDataName).parent_path().string(),
                                   fs::path(kEpisodesName).parent_path().string()};
  for (uint32_t camera = 0; camera < description.cameras.size(); ++camera)
    folders.push_back(kImagesFolder + camera_folder(description, camera));
  for (const CameraKeys& keys : camera_keys(description)) {
    folders.push_back(video_folder(keys.color));
    folders.push_back(video_folder(keys.depth));
  }
  return folders;
}

std::string LerobotLayout::color_name(const Description& description, uint64_t image) const {
  return kImagesFolder + camera_folder(description, description.index_of_camera(image)) + "/" +
         six_digits(description.frame_of(image)) + ".png";
}

Result<std::vector<std::vector<uint8_t>>> LerobotLayout::encode(const Description& description,
                                                                const sinks::FrameImage& image,
                                                                const ImageLabels&,
                                                                std::vector<uint8_t> color) const {
  std::vector<std::vector<uint8_t>> files;
  files.push_back(std::move(color));
  const auto codes = DepthCodes::of(description).encode(plane_values<float>(image, wire::kDepthF32));
  files.push_back(encode_gray_png(codes, image.width, image.height));
  return files;
}

Result<void> LerobotLayout::pack(const fs::path& folder, const Description& description,
                                 const offline::FrameLines& lines) const {
  const uint64_t frames = lines.size() / description.cameras.size();
  if (frames == 0) return {};
  const auto videos = write_videos(folder, *this, description, frames);
  if (!videos) return videos.error();
  for (const auto& [name, bytes] : encode_tables(description, frame_columns(description, lines), *videos)) {
    if (auto written = write_whole_file(folder / name, bytes); !written) return written;
  }
  return {};
}

std::string LerobotLayout::conventions(const Description& description) const {
  const Episode& episode = description.episode;
  const DepthCodes codes = DepthCodes::of(description);
  std::string text =
      R"(LeRobot v3.0 with one episode; `LeRobotDataset("name", root=DIR)` opens it, and `lerobot-edit-dataset`
merges several sets.

| file | contents |
|---|---|
| `data/chunk-000/file-000.parquet` | one row a frame |
| `videos/observation.images.CAMERA/chunk-000/file-000.mp4` | colours, H.264 (BT.709): nearly lossless |
| `videos/observation.images.CAMERA_depth/chunk-000/file-000.mp4` | depth, H.265, lossless, 12-bit grey: LeRobot 0.6 reads metres or millimetres |
| `meta/` | `info.json` (features), `stats.json`, `tasks.parquet`, `episodes/` |
| `images/CAMERA/FRAME.png`, `FRAME.depth.png` | the images that the videos were made from: colours, and depth codes of 12 bits. `fire3dv verify` and a run that continues need them, LeRobot does not |

| column | contents |
|---|---|
)";
  if (!episode.state_names.empty()) {
    text +=
        "| `observation.state` | float32; joint positions (rad, m), or poses in the world: x, y, z (m) and "
        "unit "
        "quaternions x, y, z, w with w >= 0; `names` of `meta/info.json` has which |\n";
    if (!episode.environment_names.empty())
      text += "| `observation.environment_state` | float32; poses of the other moving nodes, as above |\n";
    text +=
        "| `action` | float32; the state of the next frame, and of the last frame its own: recordings have "
        "no "
        "commands |\n";
  }
  text +=
      R"(| `camera.N.intrinsics` | 9 float64: camera matrix by rows, pixels; N counts cameras, of the table below |
| `camera.N.world_from_camera` | 16 float64: pose of the camera by rows, metres; its columns are its axes right, down, forward, and its place |
| `timestamp`, `frame_index`, `episode_index`, `index`, `task_index` | as LeRobot has them |

Depth codes 0 to 4095 are )";
  text += shortest(codes.min_m) + " m to " + shortest(codes.max_m) + " m, ";
  text += codes.is_logarithmic ? "in equal steps of log(depth + " + shortest(codes.shift_m) + " m)"
                               : "in steps of " + shortest(description.depth_unit_mm) + " mm";
  return text + "; beyond, and no surface: 4095.\n";
}

}  // namespace

std::unique_ptr<Layout> make_lerobot_layout() {
  return std::make_unique<LerobotLayout>();
}

}  // namespace fire3dv::dataset
