#include "renderer/dataset/lerobot/videos.h"

#include <algorithm>
#include <memory>
#include <set>

#include "base/files.h"
#include "base/process/progress.h"
#include "renderer/dataset/lerobot/depth_codes.h"
#include "renderer/sinks/gray_png.h"
#include "renderer/sinks/output_text.h"

namespace fire3dv::dataset {
namespace {

namespace fs = std::filesystem;

constexpr size_t kColors = 3;
constexpr const char* kFirstFile = "/chunk-000/file-000.mp4";

class CameraVideos {
 public:
  CameraVideos(const fs::path& folder, const Layout& layout, const Description& description,
               const CameraKeys& keys)
      : folder_(folder), layout_(layout), description_(description), keys_(keys) {}

  Result<void> open();
  Result<void> add(uint64_t image);
  Result<CameraStatistics> finish(uint64_t frames);

 private:
  const fs::path& folder_;
  const Layout& layout_;
  const Description& description_;
  const CameraKeys& keys_;
  std::unique_ptr<sinks::VideoFile> color_, depth_;
  PixelCounts color_counts_{kColors, 256}, depth_counts_{1, size_t{kMaxDepthCode} + 1};
};

Result<void> CameraVideos::open() {
  auto color = sinks::VideoFile::open(video_settings(description_, folder_ / video_name(keys_.color), false));
  if (!color) return color.error();
  auto depth = sinks::VideoFile::open(video_settings(description_, folder_ / video_name(keys_.depth), true));
  if (!depth) return depth.error();
  color_ = std::move(*color);
  depth_ = std::move(*depth);
  return {};
}

Result<void> CameraVideos::add(uint64_t image) {
  const auto pixels = layout_.read_color(folder_, description_, image);
  if (!pixels) return pixels.error();
  for (size_t i = 0; i < pixels->size(); i += 4) {
    for (size_t component = 0; component < kColors; ++component)
      color_counts_.add(component, (*pixels)[i + component]);
  }
  const fs::path path = folder_ / depth_name(layout_, description_, image);
  const auto png = read_whole_file(path, kMaxFileBytes);
  if (!png) return png.error();
  const auto depth = sinks::decode_gray16(*png, uint64_t{description_.width} * description_.height);
  if (!depth || depth->width != description_.width || depth->height != description_.height ||
      *std::max_element(depth->pixels.begin(), depth->pixels.end()) > kMaxDepthCode)
    return Error{path.string() + " is no depth image of this set: remove it and run the command again"};
  for (const uint16_t code : depth->pixels) depth_counts_.add(0, code);
  if (auto added = color_->add(*pixels); !added) return added;
  return depth_->add_gray12(depth->pixels);
}

Result<CameraStatistics> CameraVideos::finish(uint64_t frames) {
  for (sinks::VideoFile* const video : {color_.get(), depth_.get()}) {
    if (auto finished = video->finish(); !finished) return finished.error();
  }
  constexpr double kWhite = 255;
  const DepthCodes codes = DepthCodes::of(description_);
  return CameraStatistics{
      color_counts_.statistics([](size_t value) { return static_cast<double>(value) / kWhite; }, frames),
      depth_counts_.statistics([&](size_t code) { return codes.decode(static_cast<uint16_t>(code)); },
                               frames)};
}

}  // namespace

std::vector<CameraKeys> camera_keys(const Description& description) {
  constexpr const char* kPrefix = "observation.images.";
  std::vector<CameraKeys> keys;
  std::set<std::string> names;
  for (const std::string& camera : description.cameras) {
    const std::string name = kPrefix + sinks::safe_file_name(camera);
    keys.push_back({name, name + "_depth"});
    names.insert({name, name + "_depth"});
  }
  if (names.size() == 2 * keys.size()) return keys;
  for (uint32_t camera = 0; camera < keys.size(); ++camera) {  // some have one name
    const std::string name = kPrefix + camera_folder(description, camera);
    keys[camera] = {name, name + "_depth"};
  }
  return keys;
}

std::string video_folder(const std::string& key) {
  return "videos/" + key + "/chunk-000";
}

std::string video_name(const std::string& key) {
  return "videos/" + key + kFirstFile;
}

sinks::VideoSettings video_settings(const Description& description, const fs::path& path, bool is_depth) {
  sinks::VideoSettings settings;
  settings.path = path;
  settings.codec = is_depth ? "h265" : "h264";
  settings.is_gray12 = is_depth;
  settings.key_frame_interval = kKeyFrameInterval;
  settings.width = description.width;
  settings.height = description.height;
  settings.fps_numerator = description.episode.fps;
  settings.fps_denominator = 1;
  return settings;
}

std::string depth_name(const Layout& layout, const Description& description, uint64_t image) {
  fs::path path = layout.color_name(description, image);
  return path.replace_extension(".depth.png").string();
}

Result<std::vector<CameraStatistics>> write_videos(const fs::path& folder, const Layout& layout,
                                                   const Description& description, uint64_t frames) {
  const std::vector<CameraKeys> keys = camera_keys(description);
  std::vector<CameraStatistics> statistics;
  Progress progress("fire3dv", "videos:");
  for (size_t camera = 0; camera < keys.size(); ++camera) {
    CameraVideos videos(folder, layout, description, keys[camera]);
    if (auto opened = videos.open(); !opened) return opened.error();
    for (uint64_t frame = 0; frame < frames; ++frame) {
      if (auto added = videos.add(frame * keys.size() + camera); !added) return added.error();
      progress.update_with_end(camera * frames + frame + 1, keys.size() * frames);
    }
    auto finished = videos.finish(frames);
    if (!finished) return finished.error();
    statistics.push_back(std::move(*finished));
  }
  return statistics;
}

}  // namespace fire3dv::dataset
